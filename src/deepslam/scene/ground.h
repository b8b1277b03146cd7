// The ground plane: seen in keyframes, and once for the whole world.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/geometry/plane.h"

namespace deepslam {

struct GroundObservation {
  FrameIdx keyframe;
  Plane plane_camera;  // normal up, d = height of the camera above the ground
  // Information on (two rotations of n about axes of a tangent basis, d): see GroundTangentBasis.
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
  int num_inliers = 0;  // pixels
};

struct Ground {
  // In the tracking world; nothing when no ground was found at all.
  std::optional<Plane> plane_world;
  std::vector<GroundObservation>
      observations;  // ascending keyframes; only those where ground was seen
};

// Two unit vectors that with `normal` make a right-handed basis; columns. The tangent directions of
// a plane's normal: n' = (n + B * (a, b)^T) / |...|. A deterministic function of the normal.
[[nodiscard]] Eigen::Matrix<double, 3, 2> GroundTangentBasis(const Eigen::Vector3d& normal);

}  // namespace deepslam
