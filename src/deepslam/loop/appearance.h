// Loops by appearance: keyframes far apart along the path that show one place.
//
// Four steps. Features of every keyframe (keyframe_features.h), of long paths of every second or
// third (KeyframeStep), go into an index of words
// (similar_keyframes.h), which names at most kMaxCandidates earlier keyframes for each, so that
// work grows with the number of keyframes, not with its square. ProposeAppearanceLoops keeps the
// candidates that geometry bears out. The caller registers them by dense depth and intensity (as
// tracking does). AcceptAppearanceLoops settles contradictions and makes edges.
//
// Proposed is what fulfils all of
// - min_inliers corners agree with one relative pose (feature_pose.h), spread over kMinSpread_deg
//   of the image: one small thing is no place;
// - no other pose has more than kAmbiguityRatio of their number: things and patterns that stand
//   twice are refused;
// - the correction of the path is no more than tracking can drift between the two: drift_base_m +
//   drift_share * path, and kDriftBase_deg + kDrift_deg_per_m * path. Stretches where tracking said
//   itself that a direction was weakly constrained count with their whole length, and beyond a loss
//   nothing is bounded;
// - kMinSupport other keyframes near the new one propose the same correction, within what tracking
//   drifts between them.
// Accepted is what registration bears out: depth and intensity agree (kMinAgreement,
// kMinCorrelation), the registered pose is the corners' (kMaxMove_m, kMaxTurn_deg), kMinSupport
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
  // Corners of a keyframe, as ORB has by default.
  static constexpr int kMaxFeatures = 500;
  int max_keyframes = 4000;    // that are looked at; of longer paths every second, third, ...
  int min_gap_keyframes = 20;  // looked at between the two of a loop: about 2 m, or half a turn
  // Earlier keyframes tried for each, so that work grows with their number, not with its square.
  static constexpr int kMaxCandidates = 5;
  // Similarity of a candidate, relative to that of the keyframe and the one before it.
  static constexpr double kMinSimilarity = 0.3;
  int min_inliers = 20;
  // Deviation of the agreeing corners' directions, across the narrower side: one small thing is no
  // place.
  static constexpr double kMinSpread_deg = 3;
  // Most that another pose, or contradicting neighbours, may have of the support: no pose has half
  // as many.
  static constexpr double kAmbiguityRatio = 0.5;
  // Other keyframes near that must propose the same correction.
  static constexpr int kMinSupport = 2;
  double drift_base_m = 0.3;
  double drift_share = 0.1;
  // Largest turn of the correction without any path, as of constellations.
  static constexpr double kDriftBase_deg = 10;
  // And per path, twice that of constellations, since depth and images are compared afterwards.
  static constexpr double kDrift_deg_per_m = 3;
  // Proposals of a keyframe that are registered by dense depth, those with most corners.
  static constexpr int kMaxRegistrations = 2;
  // Share of the common depth that must agree after dense registration, a tenth more than tracking
  // asks.
  static constexpr double kMinAgreement = 0.7;
  // Correlation of the two images over the common points, half more than tracking asks.
  static constexpr double kMinCorrelation = 0.6;
  // Distance of the registered pose from that of the corners: half the gate of dense alignment.
  static constexpr double kMaxMove_m = 0.15;
  // And its turn.
  static constexpr double kMaxTurn_deg = 5;
  // Factor on the covariance of an edge, for correlated pixels, as of odometry edges
  // (object_graph.h).
  static constexpr double kVarianceScale = 10;
  // Least deviation of an edge: what does not average out between two observations of a place.
  static constexpr double kEdgeFloor_m = 0.01;
  // And of its rotation.
  static constexpr double kEdgeFloor_deg = 0.3;
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
  double intensity_correlation = 0;
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
