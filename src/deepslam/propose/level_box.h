// The upright box round what was measured of an object.
#pragma once

#include <span>

#include <Eigen/Core>

#include "deepslam/propose/level_cloud.h"
#include "deepslam/propose/proposer.h"

namespace deepslam::propose {

// Level frame (level_cloud.h).
struct LevelBox {
  double yaw_rad = 0;                                  // of the box's x axis about z
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();  // footprint's centre, level frame
  Eigen::Vector3d size_m =
      Eigen::Vector3d::Zero();  // along box x, box y, and z from the ground to the top
};

// Outliers left out. Of the yaws with nearly the smallest footprint the one whose sides the points
// are closest to (Zhang et al. 2017): two faces of a box that meet in an edge, all that is seen of
// many, fill half of the rectangle along them and half of that along the diagonal too.
[[nodiscard]] LevelBox MeasureBox(std::span<const Eigen::Vector3f> points);
// The same for a given yaw.
[[nodiscard]] LevelBox MeasureBoxAt(std::span<const Eigen::Vector3f> points, double yaw_rad);

// The box of the object's cloud. It stands along the nearest wall unless the points say otherwise:
// furniture does, and of what has no flat sides the points alone say nothing.
[[nodiscard]] LevelBox MeasureBox(const ObjectObservations& object, const LevelCloud& cloud);

}  // namespace deepslam::propose
