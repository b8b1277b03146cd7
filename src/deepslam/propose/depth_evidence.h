// What the depth images of an object's views say about a point in space: free, surface of the
// object, or unknown.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

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

  // Evidence at a point of the level frame; `slack_m` widens the tolerance (size of what is asked
  // about).
  [[nodiscard]] Evidence At(const Eigen::Vector3f& p_level, float slack_m) const;
  // How far behind the measured surface the point lies, metres; 0 or less when it does not or
  // nothing is known.
  [[nodiscard]] float DepthBehind_m(const Eigen::Vector3f& p_level) const;

 private:
  const ObjectView* view_;
  Eigen::Matrix3f rotation_;  // camera from level
  Eigen::Vector3f translation_;
  float fx_, fy_, cx_, cy_;
};

}  // namespace deepslam::propose
