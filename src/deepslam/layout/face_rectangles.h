// Rectangles of a wall's profile: what is open in it, or set back.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "deepslam/layout/wall_profile.h"

namespace deepslam::layout {

// Rows and slots [first, end) of a profile.
struct CellBox {
  int first_slot = 0;
  int end_slot = 0;
  int first_row = 0;
  int end_row = 0;

  [[nodiscard]] double width_m() const { return (end_slot - first_slot) * kCell_m; }
  [[nodiscard]] double height_m() const { return (end_row - first_row) * kCell_m; }
};

using CellTest = std::function<bool(int slot, int row)>;

// Of the cells of `box` that lie `within`, those that pass the test; 0 where none lies there.
[[nodiscard]] double ShareOf(const CellBox& box, const CellBox& within, const CellTest& test);

// The rectangles that connected cells fill which pass the test. Where bands of wall run across them
// they are several: what lies behind furniture, or was not seen above, joins them.
[[nodiscard]] std::vector<CellBox> RectanglesOf(const CellBox& within,
                                                const CellTest& test,
                                                const CellTest& wall);

// The largest rectangles within a box whose cells all pass the test, largest first, none of them
// over another; `most` at most.
[[nodiscard]] std::vector<CellBox> FullRectanglesOf(const CellBox& within,
                                                    const CellTest& test,
                                                    std::size_t most);

}  // namespace deepslam::layout
