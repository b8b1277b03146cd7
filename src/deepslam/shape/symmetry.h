// Turns about its vertical that leave a shape as it is.
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::shape {

enum class Symmetry {
  kNone,     // a chair
  kHalf,     // 180 deg: a rectangular table
  kQuarter,  // 90 deg: a square table
  kAny,      // a round table
};

// From the shape alone: a turn counts when 98 % of the turned surface lies within 1.5 voxels of the
// surface; kAny when every turn by 15 deg does.
[[nodiscard]] Symmetry SymmetryOf(const ShapeModel& model);
[[nodiscard]] Symmetry SymmetryOf(const VoxelGrid& grid);

// Whether every turn by 15 deg leaves the surface the same within this mean distance (metres, of a
// model that is `scale_m` large): round things whose rim is rough, and leaves round a stem.
[[nodiscard]] bool IsRound(const ShapeModel& model, double scale_m, double max_mean_m);

// Turns in quarters of a circle that belong to the symmetry: {0}, {0, 2} or {0, 1, 2, 3}.
[[nodiscard]] std::vector<int> QuarterTurns(Symmetry symmetry);

// Angle (rad, up to pi) of the rotation that is left when b is turned about its vertical as far as
// the symmetry allows; with kAny what is left is the lean.
[[nodiscard]] double RotationApart(const Eigen::Quaterniond& a_from_b, Symmetry symmetry);

}  // namespace deepslam::shape
