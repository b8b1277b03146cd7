// What a pose between two keyframes that their corners tell has to fulfil, and the edge that it
// becomes: common to loops (appearance.h) and neighbours (neighbours.h).
#pragma once

#include <string>

#include "deepslam/loop/appearance.h"
#include "deepslam/loop/feature_pose.h"

namespace deepslam::loop {

// No other pose has too many corners, and they are spread over more than one thing.
[[nodiscard]] bool BearsOut(const FeaturePose& pose);

// Why dense registration does not bear the loop out; empty where it does.
[[nodiscard]] std::string Verdict(const AppearanceLoop& loop,
                                  const KeyframeRegistration& registration);

// Information of an edge whose covariance is `variance_scale` times the registration's and
// (floor_m, floor_rad) squared.
[[nodiscard]] Matrix6d EdgeInformation(const Matrix6d& information,
                                       double variance_scale,
                                       double floor_m,
                                       double floor_rad);

}  // namespace deepslam::loop
