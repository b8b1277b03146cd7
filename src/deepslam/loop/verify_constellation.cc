#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "deepslam/core/angles.h"
#include "deepslam/geometry/box.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/loop/correction.h"
#include "deepslam/loop/level_icp.h"
#include "deepslam/loop/point_agreement.h"

namespace deepslam::loop {
namespace {

using Points = std::vector<Eigen::Vector3f>;

// Of the sides: what lies well inside a hollow model counts as inside.
constexpr double kBoxShrink = 0.8;
// Farther than registration errors explain: not a refinement.
constexpr double kMaxRefineMove_m = 0.30;
constexpr double kMaxRefineTurn_rad = 15.0 * kRadPerDeg;  // the same for the turn
constexpr double kWorstPairShare = 0.5;  // of min_object_agreement, for every single pair

const MapObject* Find(const ObjectMap& map, ObjectId id) {
  const auto it = std::find_if(
      map.objects.begin(), map.objects.end(), [id](const MapObject& o) { return o.id == id; });
  return it == map.objects.end() ? nullptr : &*it;
}

// One observation's knowledge of one object.
struct ObservedObject {
  Points depth;
  PointIndex surface{{}};  // model and depth together
};

ObservedObject Observed(const LoopEvidence& evidence, ObjectId id) {
  const auto it = evidence.find(id);
  if (it == evidence.end()) return {};
  ObservedObject object;
  object.depth = Thinned(it->second.depth_points_world, kThinnedCell_m);
  Points surface = Thinned(it->second.model_points_world, kThinnedCell_m);
  surface.insert(surface.end(), object.depth.begin(), object.depth.end());
  object.surface = PointIndex(std::move(surface));
  return object;
}

struct ObservedSide {
  std::vector<ObservedObject> objects;  // one per pair
  Points room;                          // without ground, without the pairs' objects
  PointIndex room_index{{}};
};

double GroundTopOf(const LoopEvidence& evidence,
                   const std::vector<ObjectId>& ids,
                   const Eigen::Vector3d& up) {
  Points objects;
  for (const ObjectId id : ids) {
    const auto it = evidence.find(id);
    if (it == evidence.end()) continue;
    for (const Points* points : {&it->second.model_points_world, &it->second.depth_points_world})
      objects.insert(objects.end(), points->begin(), points->end());
  }
  return GroundTop_m(objects, up);
}

ObservedSide GatherSide(const ObjectMap& map,
                        const LoopEvidence& evidence,
                        const std::vector<ObjectId>& ids,
                        const Eigen::Vector3d& up) {
  ObservedSide side;
  Points around;
  for (const ObjectId id : ids) {
    side.objects.push_back(Observed(evidence, id));
    const auto it = evidence.find(id);
    if (it == evidence.end()) continue;
    around.insert(
        around.end(), it->second.surroundings_world.begin(), it->second.surroundings_world.end());
  }
  const double ground_top_m = GroundTopOf(evidence, ids, up);
  for (const Eigen::Vector3f& p : Thinned(around, kThinnedCell_m)) {
    if (up.dot(p.cast<double>()) < ground_top_m) continue;
    const bool near = std::any_of(ids.begin(), ids.end(), [&](ObjectId id) {
      const MapObject* object = Find(map, id);
      return object != nullptr &&
             (object->world_from_object.translation_m - p.cast<double>()).norm() <
                 LoopOptions::kRoomRadius_m;
    });
    const bool own =
        std::any_of(side.objects.begin(), side.objects.end(), [&](const ObservedObject& object) {
          return object.surface.Nearest(p, 1.5 * LoopOptions::kVerifyDistance_m) != nullptr;
        });
    if (near && !own) side.room.push_back(p);
  }
  side.room_index = PointIndex(side.room);
  return side;
}

// ICP of four degrees of freedom over objects and surroundings.
Pose3 Refined(const ObservedSide& old_side,
              const ObservedSide& new_side,
              const Pose3& start,
              const Eigen::Quaterniond& level_from_world) {
  std::vector<Belonging> clouds;
  for (std::size_t k = 0; k < new_side.objects.size(); ++k)
    clouds.push_back({new_side.objects[k].depth, &old_side.objects[k].surface});
  clouds.push_back({new_side.room, &old_side.room_index});
  return AlignLevel(clouds, start, level_from_world, LoopOptions::kVerifyDistance_m)
      .value_or(start);
}

// The worse of both directions; nothing where neither side has points. `b_from_a` moves a onto b.
std::optional<double> ObjectAgreement(const ObservedObject& old_object,
                                      const ObservedObject& new_object,
                                      const Pose3& old_from_new) {
  std::optional<double> worse;
  const auto add = [&](const ObservedObject& a, const ObservedObject& b, const Pose3& b_from_a) {
    if (a.depth.size() < kMinComparedPoints || b.surface.size() < kMinComparedPoints) return;
    const double share =
        AgreeingShare(a.depth, b_from_a, b.surface, LoopOptions::kVerifyDistance_m);
    worse = worse ? std::min(*worse, share) : share;
  };
  add(new_object, old_object, old_from_new);
  add(old_object, new_object, old_from_new.Inverse());
  return worse;
}

std::string Percent(double share) {
  char buffer[16];
  std::snprintf(buffer, sizeof(buffer), "%.0f %%", 100 * share);
  return buffer;
}

// Share of model a's points on or well inside model b.
double ShareInside(const ObjectEvidence& a, const ObjectEvidence& b, const Pose3& world_from_b) {
  const Points points = Thinned(a.model_points_world, kThinnedCell_m);
  const Points surface = Thinned(b.model_points_world, kThinnedCell_m);
  if (points.size() < kMinComparedPoints || surface.size() < kMinComparedPoints) return 0;
  const Pose3 b_from_world = world_from_b.Inverse();
  Box3 box;
  for (const Eigen::Vector3f& p : surface) box.Extend(b_from_world * p.cast<double>());
  const PointIndex index(surface);
  std::size_t inside = 0;
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3d offset = b_from_world * p.cast<double>() - box.Center();
    const bool in_box = (offset.cwiseAbs().array() <= 0.5 * kBoxShrink * box.Size().array()).all();
    if (in_box || index.Nearest(p, LoopOptions::kVerifyDistance_m) != nullptr) ++inside;
  }
  return static_cast<double>(inside) / static_cast<double>(points.size());
}

Constellation VerifySingle(Constellation single,
                           const ObjectMap& map,
                           const LoopEvidence& evidence,
                           const LoopOptions& options) {
  const ObjectMerge& pair = single.pairs.front();
  const auto old_evidence = evidence.find(pair.kept);
  const auto new_evidence = evidence.find(pair.merged);
  const MapObject* old_object = Find(map, pair.kept);
  const MapObject* new_object = Find(map, pair.merged);
  if (old_evidence == evidence.end() || new_evidence == evidence.end() || old_object == nullptr ||
      new_object == nullptr) {
    single.reason = "single pair without models to compare";
    return single;
  }
  const double overlap = std::min(
      ShareInside(old_evidence->second, new_evidence->second, new_object->world_from_object),
      ShareInside(new_evidence->second, old_evidence->second, old_object->world_from_object));
  single.accepted =
      old_object->class_name == new_object->class_name && overlap >= options.min_single_overlap;
  single.reason = "models overlap by " + Percent(overlap);
  return single;
}

// How far the correction moves the new objects.
double LargestMove(const Constellation& constellation, const ObjectMap& map) {
  double move_m = 0;
  for (const ObjectMerge& pair : constellation.pairs) {
    const MapObject* object = Find(map, pair.merged);
    if (object == nullptr) continue;
    const Eigen::Vector3d& p = object->world_from_object.translation_m;
    move_m = std::max(move_m, (constellation.old_world_from_new_world * p - p).norm());
  }
  return move_m;
}

// Takes out pairs whose own depth contradicts; returns the mean agreement of those that stay,
// nothing without evidence.
std::optional<double> KeepAgreeingPairs(const ObservedSide& old_side,
                                        const ObservedSide& new_side,
                                        const LoopOptions& options,
                                        Constellation& constellation) {
  std::vector<ObjectMerge> kept;
  double sum = 0;
  int count = 0;
  for (std::size_t k = 0; k < constellation.pairs.size(); ++k) {
    const std::optional<double> agreement = ObjectAgreement(
        old_side.objects[k], new_side.objects[k], constellation.old_world_from_new_world);
    if (!agreement || *agreement < kWorstPairShare * options.min_object_agreement) continue;
    kept.push_back(constellation.pairs[k]);
    sum += *agreement;
    ++count;
  }
  constellation.pairs = kept;
  if (count == 0) return std::nullopt;
  return sum / count;
}

void TakeRefinement(const Pose3& refined, const ObjectMap& map, Constellation& constellation) {
  double move_m = 0;
  double squared = 0;
  int count = 0;
  for (const ObjectMerge& pair : constellation.pairs) {
    const MapObject* old_object = Find(map, pair.kept);
    const MapObject* new_object = Find(map, pair.merged);
    if (old_object == nullptr || new_object == nullptr) continue;
    const Eigen::Vector3d& p = new_object->world_from_object.translation_m;
    move_m = std::max(move_m, (refined * p - constellation.old_world_from_new_world * p).norm());
    squared += (refined * p - old_object->world_from_object.translation_m).squaredNorm();
    ++count;
  }
  const Pose3 turn = constellation.old_world_from_new_world.Inverse() * refined;
  if (count == 0 || move_m > kMaxRefineMove_m ||
      RotationAngle(turn.rotation) > kMaxRefineTurn_rad) {
    return;
  }
  constellation.old_world_from_new_world = refined;
  constellation.position_error_m = std::sqrt(squared / count);
}

// The better of both directions.
double RoomAgreement(const ObservedSide& old_side,
                     const ObservedSide& new_side,
                     const Pose3& old_from_new) {
  const double radius_m = 1.5 * LoopOptions::kVerifyDistance_m;
  return std::max(
      AgreeingShare(new_side.room, old_from_new, old_side.room_index, radius_m),
      AgreeingShare(old_side.room, old_from_new.Inverse(), new_side.room_index, radius_m));
}

// By the depth of both observations: objects, then surroundings. Where too little is known of
// these, objects alone are accepted as far as `believed_m`: equal furniture may stand elsewhere in
// an equal arrangement, but not within a foot of the first.
Constellation VerifyDepth(const Constellation& constellation,
                          const ObjectMap& map,
                          const LoopEvidence& evidence,
                          const LoopOptions& options,
                          double believed_m) {
  Constellation result = constellation;
  const std::size_t min_pairs =
      std::min(constellation.pairs.size(), static_cast<std::size_t>(LoopOptions::kMinPairs));
  std::vector<ObjectId> old_ids, new_ids;
  for (const ObjectMerge& pair : result.pairs) {
    old_ids.push_back(pair.kept);
    new_ids.push_back(pair.merged);
  }
  const Eigen::Vector3d up = UpDirection(map);
  const ObservedSide old_side = GatherSide(map, evidence, old_ids, up);
  const ObservedSide new_side = GatherSide(map, evidence, new_ids, up);
  TakeRefinement(Refined(old_side, new_side, result.old_world_from_new_world, LevelFromWorld(up)),
                 map,
                 result);

  const std::optional<double> objects = KeepAgreeingPairs(old_side, new_side, options, result);
  if (result.pairs.size() < min_pairs || !objects) {
    result.pairs = constellation.pairs;
    result.reason = "the objects' depth does not agree";
    return result;
  }
  result.reason = "objects agree by " + Percent(*objects);
  result.accepted = *objects >= options.min_object_agreement;
  const auto min_points = static_cast<std::size_t>(std::max(1, options.min_room_points));
  if (old_side.room.size() < min_points || new_side.room.size() < min_points) {
    const bool near = LargestMove(result, map) <= believed_m;
    result.reason += near ? ", surroundings unknown" : ", surroundings unknown and too far apart";
    result.accepted = result.accepted && near;
    return result;
  }
  const double room = RoomAgreement(old_side, new_side, result.old_world_from_new_world);
  result.reason += ", surroundings by " + Percent(room);
  result.accepted = result.accepted && room >= LoopOptions::kMinRoomAgreement;
  if (LargestMove(result, map) <= options.drift_base_m) return result;
  const double room_as_is = RoomAgreement(old_side, new_side, {});
  if (room_as_is > room) {
    result.reason += ", as they stand by " + Percent(room_as_is);
    result.accepted = false;
  }
  return result;
}

}  // namespace

Constellation VerifyConstellation(const Constellation& constellation,
                                  const ObjectMap& map,
                                  const LoopEvidence& evidence,
                                  const LoopOptions& options) {
  Constellation verified = constellation;
  verified.accepted = false;
  if (verified.pairs.size() > 1)
    return VerifyDepth(verified, map, evidence, options, options.drift_base_m);
  const Constellation overlapping = VerifySingle(verified, map, evidence, options);
  if (overlapping.accepted) return overlapping;
  verified = VerifyDepth(verified, map, evidence, options, options.drift_base_m);
  verified.reason = overlapping.reason + "; " + verified.reason;
  return verified;
}

Constellation VerifyReidentified(const Constellation& single,
                                 const ObjectMap& map,
                                 const LoopEvidence& evidence,
                                 const LoopOptions& options) {
  return VerifyDepth(single, map, evidence, options, 0);
}

}  // namespace deepslam::loop
