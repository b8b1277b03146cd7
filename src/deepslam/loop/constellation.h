// Loops by semantic landmarks: a similar constellation of at least two objects seen again (paper,
// "Loop detection").
//
// Three steps: FindConstellations proposes from classes and relative poses, VerifyConstellation
// looks at depth, AcceptLoops settles contradictions. Only what passes all three may touch the
// graph.
//
// Proposals. A pair (old, new) is two objects of one class that no frame sees together, the new one
// first seen at least min_gap_frames after the old one was last seen before it. Two or more pairs
// make a constellation when one correction of four degrees of freedom (translation, and yaw about
// the common up direction of all objects) brings the new objects onto the old ones:
// - positions within kPositionTolerance_m + kLocalDrift * (path travelled between the views of the
//   constellation's objects, old observation and new);
// - yaws within kYawTolerance_deg, where neither object's yaw is free (by class, or because all its
//   views say so);
// - by no more than tracking can drift on the path between the observations: drift_base_m +
//   kDriftShare * path, measured at the objects, and kDriftBase_deg + kDrift_deg_per_m * path.
// Two pairs' distance, bearing and yaws determine the correction; further pairs are added, nearest
// first, as long as all agree after a refit. Two pairs of one constellation are no start of
// another: whatever else they could lead to has a pair that is not in it, and starts with that.
// Besides, a single pair is proposed where two models stand in each other, of whatever classes:
// distance of centres below kOverlapShare * half the smaller one's longest side (a duplicate left
// by association or by a path that has been closed; no gap needed), and it was measured how they
// lie to each other: in parts of the path that nothing ties together one place may be in two rooms.
//
// Verification. The correction is refined by 4-DoF ICP over objects and surroundings; then the
// depth of either observation has to lie on the other observation's models, and the surroundings
// have to agree.
//
// Acceptance. Constellations that pair one object with different partners contradict each other,
// unless the partners are one object themselves by an accepted pair. Of two, the one with clearly
// more pairs wins (kAmbiguityRatio); else both are refused as ambiguous.
//
// All poses in the tracking world. Deterministic: everything goes in the map's order.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/core/options.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::loop {

struct LoopOptions {
  bool enabled = true;         // loops of any kind, duplicates among them
  bool constellations = true;  // of at least min_pairs objects
  // Pairs of a constellation: the paper's two.
  static constexpr int kMinPairs = 2;
  int min_gap_frames = 30;  // between the old objects' last observation and the new ones' first
  // Difference of a constellation's places after the correction: registered centres of two
  // observations differ by 5 to 10 cm each.
  static constexpr double kPositionTolerance_m = 0.15;
  // Drift of tracking between the views of one constellation, m per m of path.
  static constexpr double kLocalDrift = 0.02;
  // Difference of yaws after the correction: two registrations, each within half of it.
  static constexpr double kYawTolerance_deg = 30;
  double drift_base_m = 0.3;  // most tracking can be off between two observations
  // Largest correction per path between the observations, m per m: tracking drifts less.
  static constexpr double kDriftShare = 0.05;
  // Largest yaw correction without any path.
  static constexpr double kDriftBase_deg = 10;
  // Largest yaw correction per path between the observations.
  static constexpr double kDrift_deg_per_m = 1.5;
  // Objects of one constellation lie no further from each other: a room's diagonal.
  static constexpr double kMaxSpread_m = 6;
  bool merge_overlapping = true;  // single pairs
  // Two models of one thing: distance of their centres over half the smaller one's longest side.
  static constexpr double kOverlapShare = 0.5;
  int max_seeds = 200000;  // pairs of pairs that are tried

  // Points of the two observations this near agree: both registrations' errors and the noise at 3
  // m.
  static constexpr double kVerifyDistance_m = 0.06;
  double min_object_agreement = 0.5;
  // Share of the surroundings that must agree: half, since the two observations see different
  // parts of a room.
  static constexpr double kMinRoomAgreement = 0.5;
  int min_room_points = 300;  // fewer: surroundings say nothing
  // Surroundings count this near to the objects: a degree of the correction's yaw moves them by 5
  // cm there.
  static constexpr double kRoomRadius_m = 3.0;
  double min_single_overlap = 0.35;  // of a single pair, see VerifyConstellation
  // A contradicting constellation loses below this share of the other's pairs, two against three;
  // else both are refused.
  static constexpr double kAmbiguityRatio = 0.7;
  // Least deviation of a loop edge: what registrations of objects are good to (object_graph.h,
  // kObjectFloor_m).
  static constexpr double kEdgeFloor_m = 0.03;
  // And of its rotation.
  static constexpr double kEdgeFloor_deg = 2.0;
};

void Describe(OptionsVisitor& visitor, LoopOptions& options);

// What the stage knows about the places of the map's objects, tracking world; any part may be
// empty.
struct ObjectEvidence {
  // Measured points of the object's segments, all views together.
  std::vector<Eigen::Vector3f> depth_points_world;
  // Surface of its chosen model where it stands.
  std::vector<Eigen::Vector3f> model_points_world;
  // Measured points around it, seen in its views, without its own segment. Whole frames are best;
  // ground points and other objects may be in it and are sorted out here.
  std::vector<Eigen::Vector3f> surroundings_world;
};
using LoopEvidence = std::map<ObjectId, ObjectEvidence>;

struct FoundConstellations {
  std::vector<Constellation> constellations;
  bool complete = true;  // false: max_seeds ended the search
};

// Where constellations are looked for.
struct MappedPath {
  const ObjectMap& map;
  const Association& association;
  const ClassTable& classes;  // whose yaw is not compared
  // Gives the path lengths; where it is empty every path counts as 0, so that only the base terms
  // bound the drift.
  const Trajectory& trajectory;
  // Sub-trajectories by frame (scene/measured_parts.h): one where none is given.
  std::span<const int> part_of_frame = {};
};

// Proposals, unverified (accepted = false), those with most pairs first.
[[nodiscard]] FoundConstellations FindConstellations(const MappedPath& mapped,
                                                     const LoopOptions& options);

// The constellation with refined correction, verdict and reason.
//
// Objects: of each pair, the share of the new object's depth within kVerifyDistance_m of the old
// model (and the old depth), and the other way round; the worse counts. Pairs that reach less than
// half of min_object_agreement are taken out; with kMinPairs or more left, their mean must reach
// min_object_agreement. No depth at all: not accepted. Surroundings: without ground and without the
// pairs' objects, within kRoomRadius_m. The share of either observation's points that lie
// within 1.5 kVerifyDistance_m of the other's; the better direction counts, since one observation
// may have seen more; it must reach kMinRoomAgreement. Where an observation has fewer than
// min_room_points of them, objects alone are accepted only if the correction moves them by no more
// than drift_base_m: equal furniture in an equal arrangement may stand elsewhere. A correction that
// moves them further is refused where the surroundings agree better without it: two ends of a table
// look alike. A single pair of one class: it is enough if without any correction min_single_overlap
// of both models' points lie within kVerifyDistance_m of the other model or inside its box shrunk
// to 80 %. Else, and of two classes, depth decides as above.
[[nodiscard]] Constellation VerifyConstellation(const Constellation& constellation,
                                                const ObjectMap& map,
                                                const LoopEvidence& evidence,
                                                const LoopOptions& options);

// A single pair that association has re-identified (tracklets.h): verified as more pairs are, by
// the depth of the object and of what stands around, which has to be known here.
[[nodiscard]] Constellation VerifyReidentified(const Constellation& single,
                                               const ObjectMap& map,
                                               const LoopEvidence& evidence,
                                               const LoopOptions& options);

// From verified constellations to loops: contradictions refused, merges grouped so that each object
// is merged at most once, into the lowest id of its group, and no group holds two objects that one
// frame sees apart. Edges tie the keyframes of the best views of both observations. All
// constellations come back in `constellations`, with their final verdict.
[[nodiscard]] Loops AcceptLoops(std::span<const Constellation> verified,
                                const ObjectMap& map,
                                const Association& association,
                                const Trajectory& trajectory = {});

// What a further search found, in the map that the merges of `all` made. Merged objects still go to
// what is kept at last; refused constellations that come again take the place of the earlier ones.
void Append(Loops more, Loops& all);

}  // namespace deepslam::loop
