// The cells that heads of the YOLO family predict in: those of three grids that are laid over the
// input.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "deepslam/detect/letterbox.h"

namespace deepslam::detect {

inline constexpr std::array<int, 3> kStrides = {8, 16, kCoarsestStride_px};  // px

struct GridCell {
  int u = 0;  // column and row in its grid
  int v = 0;
  int stride = 0;
};

// Of one grid.
[[nodiscard]] std::int64_t NumCells(Sides input, int stride);
// Of all of them.
[[nodiscard]] std::int64_t NumCells(Sides input);

// In the order of a head's output: by grids, the finest first, and by rows.
[[nodiscard]] std::vector<GridCell> GridCells(Sides input);

}  // namespace deepslam::detect
