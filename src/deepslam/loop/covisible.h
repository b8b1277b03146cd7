// Keyframes that see the same surfaces though tracking did not align them with each other: a camera
// that sweeps to and fro sees a place many times, and each pair of such views that is measured
// takes some of the drift between them. Nothing is recognised here: tracking itself says which
// pairs they are, so they lie within what it drifts over a few metres. Places seen again after a
// longer way are appearance.h's.
//
// Proposed is a pair of keyframes that tracking has not joined, at most max_gap_keyframes apart
// along the path, with no loss between, whose tracked poses lie within kMaxDistance_m and
// kMaxTurn_deg. The caller registers it by dense depth and intensity, as tracking does. Accepted
// is what agrees and stays near the tracked pose; kept, once the caller has solved the graph with
// these edges, what the solution does not contradict.
//
// All poses in the tracking world. Deterministic.
#pragma once

#include <cstddef>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/loop/appearance.h"
#include "deepslam/loop/keyframe_path.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::loop {

struct CovisibleOptions {
  bool enabled = true;
  int max_gap_keyframes = 60;  // so that work grows with the number of keyframes
  int max_pairs = 12;          // for each keyframe, spread evenly over those before it
  // Distance of the two as tracked: beyond, too little of a room is in both views.
  static constexpr double kMaxDistance_m = 1.5;
  // And their turn: most of a view of 60 degrees is then new.
  static constexpr double kMaxTurn_deg = 45;
  // Share of the common depth that must agree, as of loops (appearance.h).
  static constexpr double kMinAgreement = 0.7;
  // Correlation of the two images over the common points, as of loops.
  static constexpr double kMinCorrelation = 0.6;
  // Distance of the registered pose from the tracked one: tracking drifts less over 60 keyframes,
  // 6 m.
  static constexpr double kMaxMove_m = 0.15;
  // And its turn.
  static constexpr double kMaxMove_deg = 5;
  // Distance of an edge from the path that all of them make; others are left out.
  static constexpr double kMaxResidual_m = 0.05;
  // And its turn.
  static constexpr double kMaxResidual_deg = 2;
};

void Describe(OptionsVisitor& visitor, CovisibleOptions& options);

struct CovisiblePair {
  int older = 0, newer = 0;  // positions in Odometry::keyframes
  Pose3 older_from_newer;    // as tracked
};

// The proposals, ascending by the newer keyframe, then by the older one: a few at a time, since
// those of a long path are as many as its edges.
class CovisiblePairs {
 public:
  // Of a path as tracked, which must outlive this and stay as it is.
  CovisiblePairs(const Odometry& odometry, const CovisibleOptions& options);

  // The next ones; fewer than `most` only when none are left.
  [[nodiscard]] std::vector<CovisiblePair> Next(std::size_t most);

 private:
  [[nodiscard]] std::vector<CovisiblePair> Of(int newer) const;

  const CovisibleOptions options_;
  const KeyframePath path_;
  const std::set<std::pair<int, int>> joined_;  // by tracking
  const int num_keyframes_;
  int next_ = 0;                     // keyframe
  std::vector<CovisiblePair> left_;  // of the keyframes before it
};

// An edge for each pair that its registration bears out, with the registration's information as
// tracking's edges have theirs. `registrations`: one per pair.
[[nodiscard]] std::vector<RelativePose> AcceptCovisible(
    std::span<const CovisiblePair> pairs,
    std::span<const KeyframeRegistration> registrations,
    const Trajectory& trajectory);

// That the poses of `solved` agree with the edge.
[[nodiscard]] bool IsConsistent(const RelativePose& edge, const Trajectory& solved);

}  // namespace deepslam::loop
