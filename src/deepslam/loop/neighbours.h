// Keyframes next to each other of which tracking's own measurement is poor, measured again as loops
// are (appearance.h): corners propose a pose, dense depth and brightness have to bear it out.
//
// Poor are measurements
// - across a loss: all pairs of the three keyframes before and the three after it;
// - by depth alone: every pair that tracking joined. Along bare walls depth slides, and what slid
// on
//   opposite sides cancels in every loop's sum: a path closes on itself and is too short all the
//   same.
//
// All poses in the tracking world. Deterministic, for any thread count.
#pragma once

#include <span>
#include <vector>

#include "deepslam/loop/appearance.h"

namespace deepslam::loop {

// Pairs whose corners tell one pose (min_inliers, min_spread_deg, ambiguity_ratio), in the order of
// the keyframes. What tracking says of their poses is what is in doubt, so it bounds nothing.
// `features` in the order of odometry.keyframes.
[[nodiscard]] std::vector<AppearanceLoop> ProposeNeighbours(
    std::span<const KeyframeFeatures> features,
    const Odometry& odometry,
    bool depth_alone,
    const AppearanceOptions& options);

// An edge for each proposal that its registration bears out. Their errors average out along the
// path as those of odometry do, so edge_floor is not added.
[[nodiscard]] std::vector<RelativePose> AcceptNeighbours(
    std::span<const AppearanceLoop> proposed,
    std::span<const KeyframeRegistration> registrations,
    const AppearanceOptions& options);

}  // namespace deepslam::loop
