// Matchers that print both values and the tolerance with its unit.
#pragma once

#include <numbers>

#include <gmock/gmock.h>

#include "deepslam/geometry/pose.h"

namespace deepslam::testing_support {

MATCHER_P3(PoseNear, expected, tolerance_m, tolerance_deg, "") {
  const Pose3 difference = expected.Inverse() * arg;
  const double distance_m = difference.translation_m.norm();
  const double angle_deg = RotationAngle(difference.rotation) * 180.0 / std::numbers::pi;
  *result_listener << "differs by " << distance_m << " m (tolerance " << tolerance_m << " m) and "
                   << angle_deg << " deg (tolerance " << tolerance_deg << " deg); translation is ("
                   << arg.translation_m.transpose() << "), expected ("
                   << expected.translation_m.transpose() << ")";
  return distance_m <= tolerance_m && angle_deg <= tolerance_deg;
}

}  // namespace deepslam::testing_support
