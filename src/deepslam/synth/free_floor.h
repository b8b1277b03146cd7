// Where in a home one can walk, and the ways there.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "deepslam/synth/home_plan.h"

namespace deepslam::synth {

// A grid of cells from wall to wall. Free are those in rooms and doors with room for a person who
// holds a camera, and from which most of the home can be walked to.
class FreeFloor {
 public:
  static constexpr double kCell_m = 0.1;  // fine against doors of 0.9 m

  FreeFloor(const HomePlan& plan, const std::vector<FloorRectangle>& taken);

  // Of a cell's middle.
  [[nodiscard]] Eigen::Vector2d PlaceOf(int cell) const;
  // The free cell of a rectangle that is nearest to a place.
  [[nodiscard]] std::optional<int> Nearest(const Eigen::Vector2d& place,
                                           const FloorRectangle& within) const;
  // Cells from one to another, both included, off the walls where there is room; none where no way
  // leads there.
  [[nodiscard]] std::vector<int> Way(int from, int to) const;

 private:
  void KeepLargestPart();

  Eigen::Vector2d half_;
  int nx_, ny_;
  std::vector<std::uint8_t> free_;
  std::vector<double> effort_;  // as many times as long as on open floor
};

}  // namespace deepslam::synth
