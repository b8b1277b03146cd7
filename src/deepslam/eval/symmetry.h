// Turns about its vertical that leave a shape as it is.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::eval {

enum class Symmetry {
  kNone,     // a chair
  kHalf,     // 180 deg: a rectangular table
  kQuarter,  // 90 deg: a square table
  kAny,      // a round table
};

// From the shape alone: a turn counts when 98 % of the turned surface lies within 1.5 voxels of the
// surface; kAny when every turn by 15 deg does.
[[nodiscard]] Symmetry SymmetryOf(const VoxelGrid& grid);

// Turns in quarters of a circle that belong to the symmetry: {0}, {0, 2} or {0, 1, 2, 3}.
[[nodiscard]] std::vector<int> QuarterTurns(Symmetry symmetry);

// The grid turned about z by quarters of a circle, counter-clockwise seen from above.
[[nodiscard]] VoxelGrid Turned(const VoxelGrid& grid, int quarters);

}  // namespace deepslam::eval
