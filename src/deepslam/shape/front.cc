#include "deepslam/shape/front.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

namespace deepslam::shape {

namespace {

// Where the upper part of a shape stands in its footprint; places in voxels.
struct Footprint {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  // of all columns that hold something
  Eigen::Vector2d high = Eigen::Vector2d::Zero();    // of the voxels in the upper part
  Eigen::AlignedBox2d box;
  bool has_high = false;
};

Footprint FootprintOf(const VoxelGrid& grid) {
  int top = 0;
  int bottom = kGridSize;
  for (int n = 0; n < kGridSize * kGridSize * kGridSize; ++n) {
    if (grid.occupied[static_cast<std::size_t>(n)] == 0) continue;
    top = std::max(top, n % kGridSize + 1);
    bottom = std::min(bottom, n % kGridSize);
  }
  // Seats and mattresses lie below, arm rests rise no higher.
  constexpr double kBackBegins = 0.72;  // of the height
  const double begin = bottom + kBackBegins * (top - bottom);
  Footprint footprint;
  double num_high = 0;
  double num_columns = 0;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      bool is_column = false;
      for (int k = bottom; k < top; ++k) {
        if (!grid.At(i, j, k)) continue;
        is_column = true;
        if (k < begin) continue;
        footprint.high += Eigen::Vector2d(i, j);
        num_high += 1;
      }
      if (!is_column) continue;
      footprint.box.extend(Eigen::Vector2d(i, j));
      footprint.middle += Eigen::Vector2d(i, j);
      num_columns += 1;
    }
  }
  footprint.has_high = num_high > 0;
  if (footprint.has_high) {
    footprint.high /= num_high;
    footprint.middle /= num_columns;
  }
  return footprint;
}

// The turns that bring the high part to -x when it stands off `middle`; nothing where it is there.
std::optional<int> TurnsOf(const Footprint& footprint, const Eigen::Vector2d& middle) {
  const Eigen::Vector2d offset =
      ((footprint.high - middle).array() / (footprint.box.sizes().array() + 1.0)).matrix();
  // Of the footprint; a back leaning on the rim stands at 0.4, a stool's seat at 0.
  constexpr double kClear = 0.15;
  if (offset.cwiseAbs().maxCoeff() < kClear) return std::nullopt;
  if (std::abs(offset.x()) >= std::abs(offset.y())) return offset.x() > 0 ? 2 : 0;
  // Back at +y: one turn counter-clockwise brings it to -x.
  return offset.y() > 0 ? 1 : 3;
}

}  // namespace

int QuarterTurnsToFront(const VoxelGrid& grid) {
  const Footprint footprint = FootprintOf(grid);
  return footprint.has_high ? TurnsOf(footprint, footprint.box.center()).value_or(0) : 0;
}

std::optional<int> QuarterTurnsFromHighBack(const VoxelGrid& grid) {
  const Footprint footprint = FootprintOf(grid);
  return footprint.has_high ? TurnsOf(footprint, footprint.middle) : std::nullopt;
}

}  // namespace deepslam::shape
