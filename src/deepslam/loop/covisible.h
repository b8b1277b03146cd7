// Keyframes that see the same surfaces though tracking did not align them with each other: a camera
// that sweeps to and fro sees a place many times, and each pair of such views that is measured
// takes some of the drift between them. Nothing is recognised here: tracking itself says which
// pairs they are, so they lie within what it drifts over a few metres. Places seen again after a
// longer way are appearance.h's.
//
// Proposed is a pair of keyframes that tracking has not joined, at most max_gap_keyframes apart
// along the path, with no loss between, whose tracked poses lie within max_distance_m and
// max_turn_deg. The caller registers it by dense depth and brightness, as tracking does. Accepted
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
  double max_distance_m = 1.5;
  double max_turn_deg = 45;
  double min_agreement = 0.7;
  double min_correlation = 0.6;
  double max_move_m = 0.15;  // of registration from the tracked pose
  double max_move_deg = 5;
  double max_residual_m = 0.05;  // of an edge from the solved path
  double max_residual_deg = 2;
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
    const Trajectory& trajectory,
    const CovisibleOptions& options);

// That the poses of `solved` agree with the edge.
[[nodiscard]] bool IsConsistent(const RelativePose& edge,
                                const Trajectory& solved,
                                const CovisibleOptions& options);

}  // namespace deepslam::loop
