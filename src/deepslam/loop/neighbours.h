// Keyframes next to each other of which tracking's own measurement is poor, re-registered as loops
// are (appearance.h): corners propose a pose, dense depth and intensity have to bear it out.
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

#include <compare>
#include <span>
#include <vector>

#include "deepslam/loop/appearance.h"

namespace deepslam::loop {

// Positions in Odometry::keyframes, older < newer <= older + kMostNeighbourGap.
struct NeighbourPair {
  int older = 0;
  int newer = 0;
  friend auto operator<=>(const NeighbourPair&, const NeighbourPair&) = default;
};
// Three keyframes before a loss and three after it, each with each.
inline constexpr int kMostNeighbourGap = 5;

// Ascending by the newer one, then by the older one.
[[nodiscard]] std::vector<NeighbourPair> PoorlyMeasured(const Odometry& odometry, bool depth_alone);

// Of the pairs those whose corners tell one pose (min_inliers, min_spread_deg, ambiguity_ratio), in
// their order. What tracking says of their poses is what is in doubt, so it bounds nothing.
// `features`: of keyframes that follow each other, the first of them at position `first`; pairs of
// others are left out. So a long path can be gone through piece by piece.
[[nodiscard]] std::vector<AppearanceLoop> ProposeNeighbours(
    std::span<const NeighbourPair> pairs,
    std::span<const KeyframeFeatures> features,
    int first,
    const AppearanceOptions& options);

// An edge for each proposal that its registration bears out. Their errors average out along the
// path as those of odometry do, so edge_floor is not added.
[[nodiscard]] std::vector<RelativePose> AcceptNeighbours(
    std::span<const AppearanceLoop> proposed, std::span<const KeyframeRegistration> registrations);

}  // namespace deepslam::loop
