// The world people want: z up, ground z = 0.
#pragma once

#include <optional>

#include "deepslam/core/quarter_turn.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::graph {

// gravity_from_tracking. With a ground: z is its normal, the ground is z = 0, the origin is the
// foot of the first camera on the ground, x is its viewing direction projected on the ground. A
// camera that looks within 5 deg of straight down (up) has none: the upper (lower) edge of its
// image is forward then. Without a ground: the first camera counts as upright, so z = its -y, x =
// its z, origin = its centre. Images are taken as `upright` turns them.
[[nodiscard]] Pose3 GravityFromTracking(const Pose3& tracking_from_first_camera,
                                        const std::optional<Plane>& ground_tracking,
                                        QuarterTurn upright = QuarterTurn::kNone);

}  // namespace deepslam::graph
