// Thinned points with normals of one depth image, for plane search and fitting.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"

namespace deepslam::ground {

struct GroundPoint {
  Eigen::Vector3f p_camera;       // m
  Eigen::Vector3f normal_camera;  // unit, towards the camera
  float sigma_m = 0;              // depth noise along the ray, one standard deviation
};

struct GroundPoints {
  std::vector<GroundPoint> points;
  int step_px = 1;   // distance of neighbouring points in the image
  int num_grid = 0;  // grid positions, valid or not
};

// Every step-th pixel in both directions, about 160 a row; normals span two steps. Invalid, far and
// non-finite depth and points at depth edges are left out. Empty when the image has not the
// camera's size.
[[nodiscard]] GroundPoints ExtractGroundPoints(const DepthImage& depth_m,
                                               const PinholeCamera& camera,
                                               double max_depth_m);

}  // namespace deepslam::ground
