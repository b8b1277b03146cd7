// A plane n . x + d = 0 with unit n. For the ground n points up, so d > 0 is the height of the
// frame's origin above it.
#pragma once

#include <Eigen/Core>

#include "deepslam/geometry/pose.h"

namespace deepslam {

struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double d_m = 0;

  [[nodiscard]] double SignedDistance(const Eigen::Vector3d& x) const {
    return normal.dot(x) + d_m;
  }
  friend bool operator==(const Plane& a, const Plane& b) {
    return a.normal == b.normal && a.d_m == b.d_m;
  }
};

// (n, d)_b = (R n, d - (R n)^T t) for b_from_a = (R, t).
[[nodiscard]] inline Plane Transformed(const Pose3& b_from_a, const Plane& plane_a) {
  const Eigen::Vector3d normal_b = b_from_a.rotation * plane_a.normal;
  return {normal_b, plane_a.d_m - normal_b.dot(b_from_a.translation_m)};
}

// The rotation that turns `from` into `to` by the shortest way (unit vectors; any axis when
// opposite).
[[nodiscard]] Eigen::Quaterniond ShortestRotation(const Eigen::Vector3d& from,
                                                  const Eigen::Vector3d& to);

}  // namespace deepslam
