// Poses for frames that have none of their own.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "deepslam/geometry/pose.h"

namespace deepslam::tracking {

// Missing poses are interpolated by time between the nearest given ones (by index where the times
// do not increase), and carried from the nearest one at either end. All identity when none is
// given. Same length for both arguments.
[[nodiscard]] std::vector<Pose3> InterpolateMissing(std::span<const std::optional<Pose3>> poses,
                                                    std::span<const double> times_s);

}  // namespace deepslam::tracking
