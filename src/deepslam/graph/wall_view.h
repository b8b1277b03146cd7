// Walls as single keyframes saw them.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/geometry/plane.h"

namespace deepslam::graph {

struct WallView {
  FrameIdx keyframe;
  int wall = 0;        // position in WallViews::planes
  Plane plane_camera;  // normal to the side that the camera is on
  // Information on (two rotations of n about axes of a tangent basis, d): see GroundTangentBasis.
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
  int num_inliers = 0;  // pixels
};

struct WallViews {
  std::vector<Plane> planes;    // of walls, in the world of the path that they were measured along
  std::vector<WallView> views;  // ascending keyframes, then walls
};

}  // namespace deepslam::graph
