// What the depth images of an object's views say about a point in space: free, surface of the
// object, or unknown.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::propose {

enum class Evidence {
  kUnknown,  // outside the crop, invalid depth, or near a surface that is not the object's
  kFree,     // the ray goes on clearly behind the point
  kSurface,  // the object's segment lies at the point
  kBehind,   // the ray ends before the point
};

// Measurement tolerance at a depth: 1.5 cm of alignment and calibration, and noise growing with the
// square of the depth as for structured light.
[[nodiscard]] inline float DepthTolerance_m(float depth_m) {
  return 0.015F + 0.003F * depth_m * depth_m;
}

class DepthView {
 public:
  // `view` must outlive the object.
  DepthView(const ObjectView& view, const Pose3& level_from_world);

  struct Reading {
    Evidence evidence = Evidence::kUnknown;
    // Distance of the point behind the object's measured surface, along that surface's normal,
    // metres; 0 when it is not behind the object.
    float behind_m = 0;
  };
  // Evidence at a point of the level frame. `slack_m` widens the tolerance across the surface (size
  // of what is asked about): along a grazing ray it grows.
  [[nodiscard]] Reading At(const Eigen::Vector3f& p_level, float slack_m) const;

 private:
  const ObjectView* view_;
  Image<float> cosine_;       // of the angle between ray and surface normal, per pixel
  Eigen::Matrix3f rotation_;  // camera from level
  Eigen::Vector3f translation_;
  float fx_, fy_, cx_, cy_;
};

}  // namespace deepslam::propose
