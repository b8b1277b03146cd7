// Point-to-point ICP of the four degrees of freedom that drift has where the ground is known:
// translation, and yaw about the up direction.
#pragma once

#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "deepslam/geometry/pose.h"
#include "deepslam/loop/point_agreement.h"

namespace deepslam::loop {

// Points of frame a that belong on those of frame b.
struct Belonging {
  std::span<const Eigen::Vector3f> points_a;
  const PointIndex* points_b = nullptr;
};

// b_from_a, beginning at `start`. Nearest neighbours count within 0.3 m at first and within
// `last_radius_m` at last. Nothing where fewer than 30 points have one.
[[nodiscard]] std::optional<Pose3> AlignLevel(std::span<const Belonging> clouds,
                                              const Pose3& start,
                                              const Eigen::Quaterniond& level_from_world,
                                              double last_radius_m);

}  // namespace deepslam::loop
