// One rendered view before it is cut out: per pixel of a small image round the object.
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/render/ray_scene.h"

namespace deepslam::priors {

struct Raster {
  PinholeCamera camera;
  Pose3 object_from_camera;
  Plane ground_camera;
  Image<Eigen::Vector3f> rays;  // through each pixel, unit, object frame
  Image<render::RayHit> hits;   // instance -1: nothing
  DepthImage true_depth_m;      // along the axis, 0 where nothing is hit

  // What camera and segmentation make of it.
  Image<Eigen::Vector3f> colour;  // display values in [0, 1]; any outside the mask
  DepthImage depth_m;
  Mask mask;

  [[nodiscard]] int width() const { return hits.width(); }
  [[nodiscard]] int height() const { return hits.height(); }
};

}  // namespace deepslam::priors
