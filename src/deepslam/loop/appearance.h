// Loops by appearance: keyframes far apart along the path that show one place.
//
// Four steps. Features of every keyframe (keyframe_features.h), of long paths of every second or
// third (KeyframeStep), go into an index of words
// (similar_keyframes.h), which names at most max_candidates earlier keyframes for each, so that
// work grows with the number of keyframes, not with its square. ProposeAppearanceLoops keeps the
// candidates that geometry bears out. The caller registers them by dense depth and brightness (as
// tracking does). AcceptAppearanceLoops settles contradictions and makes edges.
//
// Proposed is what fulfils all of
// - min_inliers corners agree with one relative pose (feature_pose.h), spread over min_spread_deg
//   of the image: one small thing is no place;
// - no other pose has more than ambiguity_ratio of their number: things and patterns that stand
//   twice are refused;
// - the correction of the path is no more than tracking can drift between the two: drift_base_m +
//   drift_share * path, and drift_base_deg + drift_deg_per_m * path. Stretches where tracking said
//   itself that a direction was weakly constrained count with their whole length, and beyond a loss
//   nothing is bounded;
// - min_support other keyframes near the new one propose the same correction, within what tracking
//   drifts between them.
// Accepted is what registration bears out: depth and brightness agree (min_agreement,
// min_correlation), the registered pose is the corners' (max_move_m, max_turn_deg), min_support
// registered neighbours still say the same, and no neighbours that are as many say otherwise.
//
// All poses in the tracking world. Deterministic, for any thread count.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/loop/keyframe_features.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::loop {

struct AppearanceOptions {
  bool enabled = true;
  int max_features = 500;       // per keyframe
  int max_keyframes = 4000;     // that are looked at; of longer paths every second, third, ...
  int min_gap_keyframes = 20;   // looked at between the two of a loop: about 2 m, or half a turn
  int max_candidates = 5;       // per keyframe
  double min_similarity = 0.3;  // of what a keyframe and the one before it have in common
  int min_inliers = 20;
  double min_spread_deg = 3;
  double ambiguity_ratio = 0.5;
  int min_support = 2;
  double drift_base_m = 0.3;
  double drift_share = 0.1;
  double drift_base_deg = 10;
  double drift_deg_per_m = 3;
  int max_registrations = 2;  // per keyframe: the proposals with most corners
  double min_agreement = 0.7;
  double min_correlation = 0.6;
  double max_move_m = 0.15;  // of registration from the corners' pose
  double max_turn_deg = 5;
  double variance_scale = 10;  // of an edge's covariance, as of odometry edges
  double edge_floor_m = 0.01;  // what does not average out between two visits
  double edge_floor_deg = 0.3;
};

void Describe(OptionsVisitor& visitor, AppearanceOptions& options);

// One keyframe in so many is looked at, so that they are max_keyframes at most.
[[nodiscard]] int KeyframeStep(std::size_t num_keyframes, const AppearanceOptions& options);

// What dense registration found of a proposal.
struct KeyframeRegistration {
  bool ok = false;
  Pose3 old_from_new;
  Matrix6d information = Matrix6d::Identity();  // of t2v, (translation m; rotation rad)
  double agreement = 0;                         // share of the common depth
  double brightness_correlation = 0;
};

// Proposals in the order of the new keyframes. `features` of some or all of odometry.keyframes, in
// their order; entries that are no keyframes of it are left out.
[[nodiscard]] std::vector<AppearanceLoop> ProposeAppearanceLoops(
    std::span<const KeyframeFeatures> features,
    const Odometry& odometry,
    const AppearanceOptions& options);

// `registrations`: one per proposal. Returns the loops with their verdicts, and an edge per
// accepted one, in turn.
struct AcceptedAppearance {
  std::vector<AppearanceLoop> loops;
  std::vector<RelativePose> edges;
};
[[nodiscard]] AcceptedAppearance AcceptAppearanceLoops(
    std::span<const AppearanceLoop> proposed,
    std::span<const KeyframeRegistration> registrations,
    const Odometry& odometry,
    const AppearanceOptions& options);

// After the graph was solved with the edges: those that the solution contradicts (by more than
// three edge_floor and what tracking drifts within a metre) are refused. True when there were any,
// so that the graph is to be solved again.
[[nodiscard]] bool RefuseContradicted(const Trajectory& solved,
                                      const AppearanceOptions& options,
                                      AcceptedAppearance& accepted);

}  // namespace deepslam::loop
