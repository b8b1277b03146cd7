#include "deepslam/modelling/close_loops.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/loop/shared_place.h"
#include "deepslam/loop/tracklets.h"
#include "deepslam/mapping/keyframe_graph.h"
#include "deepslam/modelling/loop_evidence.h"
#include "deepslam/modelling/merge_objects.h"
#include "deepslam/modelling/moved_objects.h"
#include "deepslam/modelling/rescore_objects.h"
#include "deepslam/modelling/split_tracks.h"
#include "deepslam/scene/object_map.h"

namespace deepslam::modelling {
namespace {

// Every pass closes the path further; what two passes leave, a third seldom finds.
constexpr int kMaxPasses = 6;

// Objects are where the path that appearance closed puts them.
LoopWorld WorldOf(MapWithLoops before) {
  LoopWorld world;
  world.tracked = std::move(before.tracked);
  world.odometry = std::move(before.odometry);
  world.ground = std::move(before.ground);
  world.edges = std::move(before.appearance.edges);
  world.association = std::move(before.association);
  world.proposals = std::move(before.proposals);
  world.map = std::move(before.map);
  MoveObjects(world.tracked, world.odometry, world.map);
  return world;
}

// The proposed constellations, then the observations that association said to be one, by what depth
// says of each.
Result<std::vector<Constellation>> Verify(const std::vector<Constellation>& proposed,
                                          const std::vector<Constellation>& reobserved,
                                          const LoopClosing& closing,
                                          const LoopWorld& world) {
  std::vector<Constellation> verified(proposed.size() + reobserved.size());
  if (verified.empty()) return verified;  // most captures propose nothing, evidence takes all views
  std::set<ObjectId> all;
  for (const MapObject& object : world.map.objects) all.insert(object.id);
  const Result<loop::LoopEvidence> evidence = CollectEvidence(all, closing, world);
  if (!evidence.ok()) return evidence.error();
  ParallelFor(proposed.size(), [&](std::size_t i) {
    verified[i] = loop::VerifyConstellation(proposed[i], world.map, *evidence, closing.loops);
  });
  ParallelFor(reobserved.size(), [&](std::size_t i) {
    verified[proposed.size() + i] =
        loop::VerifyReidentified(reobserved[i], world.map, *evidence, closing.loops);
  });
  return verified;
}

Result<Loops> DetectLoops(const std::vector<SplitTracklet>& tracklets,
                          const LoopClosing& closing,
                          const LoopWorld& world) {
  const loop::LoopOptions& options = closing.loops;
  const std::vector<int> parts = PartsOf(world);
  loop::FoundConstellations found = loop::FindConstellations(
      {world.map, world.association, closing.classes, world.odometry, parts}, options);
  if (!found.complete) {
    closing.sources.progress.Warn(
        fmt::format("loops.max_seeds: {} starts of constellations were tried and more are left, so "
                    "loops may be missing; raise it, or lower loops.max_spread_m",
                    options.max_seeds));
  }
  const std::vector<Constellation> reobserved =
      loop::ProposeReidentified(tracklets, world.map, found.constellations);
  const Result<std::vector<Constellation>> verified =
      Verify(found.constellations, reobserved, closing, world);
  if (!verified.ok()) return verified.error();
  return loop::AcceptLoops(*verified, world.map, world.association, world.odometry);
}

// The path is closed by what ties it together so far, where that moves what was seen of an object
// apart. Whether it was.
Result<bool> ClosePath(const std::set<ObjectId>& just_scored,
                       const LoopClosing& closing,
                       LoopWorld& world) {
  if (!closing.graph.use_objects) return false;
  Result<mapping::SolvedPath> solved =
      mapping::SolvePath(world.odometry, world.ground, world.edges, closing.graph, world.map);
  if (!solved.ok()) return solved.error();
  Trajectory closed{std::move(solved->frames), world.odometry.keyframes};
  const bool apart = std::ranges::any_of(world.map.objects, [&](const MapObject& object) {
    const Eigen::Vector3d& centre = object.world_from_object.translation_m;
    return MovedApart_m(world.odometry, closed, object, centre) > loop::kApart_m;
  });
  if (!apart) return false;
  const Trajectory before{std::exchange(world.odometry.frames, std::move(closed.frames)),
                          world.odometry.keyframes};
  world.ground = std::move(solved->ground);
  for (std::size_t k = 0; k < world.map.objects.size(); ++k)
    world.map.objects[k].world_from_object = solved->world_from_object[k];
  if (Status status = RescoreMovedApart(before, just_scored, closing, world); !status.ok())
    return status.error();
  return true;
}

// One pass of the search along the path as it is, and the path closed by what it finds. Whether it
// found anything or moved anything.
Result<bool> SearchOnce(const LoopClosing& closing, LoopWorld& world, Loops& all) {
  Result<Loops> found = DetectLoops(all.tracklets, closing, world);
  if (!found.ok()) return found.error();
  std::set<ObjectId> just_scored;
  for (const ObjectMerge& merge : found->merges) just_scored.insert(merge.kept);
  if (Status status = MergeObjects(*found, closing, world); !status.ok()) return status.error();
  world.edges.insert(world.edges.end(), found->edges.begin(), found->edges.end());
  const bool merged = !found->merges.empty();
  loop::Append(std::move(found).value(), all);
  const Result<bool> moved = ClosePath(just_scored, closing, world);
  if (!moved.ok()) return moved.error();
  return merged || *moved;
}

// Objects whose tracks were split and whose observations no loop joined are whole again; of others
// the observations that are left.
Status Rejoin(const WholeObjects& whole,
              const LoopClosing& closing,
              LoopWorld& world,
              Loops& loops) {
  const loop::RejoinedTracklets rejoined = loop::RejoinTracklets(loops.tracklets, loops.merges);
  if (Status status = RejoinTracks(rejoined.whole, whole, closing, world); !status.ok())
    return status;
  const Loops again{{}, rejoined.merges, {}, {}, {}};
  if (Status status = MergeObjects(again, closing, world); !status.ok()) return status;
  loop::Append(again, loops);
  return Ok();
}

// Constellations and duplicates, again and again along the path that they close, observations of
// doubtful objects by themselves until nothing more is found among them.
Result<Loops> SearchLoops(const LoopClosing& closing, LoopWorld& world) {
  Loops loops;
  if (!closing.loops.enabled) return loops;
  const Result<loop::SplitObjects> splits = FindSplits(closing, world);
  if (!splits.ok()) return splits.error();
  const Result<WholeObjects> whole = SplitTracks(*splits, closing, world);
  if (!whole.ok()) return whole.error();
  loops.tracklets = splits->tracklets;
  bool is_split = !splits->tracklets.empty();
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    if (closing.sources.progress.StopRequested()) return Interrupted();
    const Result<bool> found = SearchOnce(closing, world, loops);
    if (!found.ok()) return found.error();
    if (*found) continue;
    if (!is_split) break;
    if (Status status = Rejoin(*whole, closing, world, loops); !status.ok()) return status.error();
    is_split = false;
  }
  return loops;
}

// Objects that stand in a surer one leave the map, and the map says so.
Status DropDuplicates(const LoopClosing& closing, LoopWorld& world) {
  const loop::LoopOptions& options = closing.loops;
  ObjectMap& map = world.map;
  const std::vector<loop::Duplicate> suspects =
      loop::SuspectDuplicates(map, options, PartsOf(world));
  if (suspects.empty()) return Ok();
  std::set<ObjectId> wanted;
  for (const loop::Duplicate& suspect : suspects) wanted.insert({suspect.id, suspect.host});
  const Result<loop::LoopEvidence> evidence = CollectEvidence(wanted, closing, world);
  if (!evidence.ok()) return evidence.error();
  std::map<ObjectId, std::string> names;
  for (const MapObject& object : map.objects) names[object.id] = ObjectName(object);
  for (const loop::Duplicate& duplicate : loop::FindDuplicates(suspects, map, *evidence)) {
    map.dropped.push_back(fmt::format(
        "{}: stands in {}, which is surer", names[duplicate.id], names[duplicate.host]));
    std::erase_if(map.objects, [&](const MapObject& object) { return object.id == duplicate.id; });
  }
  return Ok();
}

// What was made for objects that are still there. Tracklets that stay objects of their own have
// copies of their object's candidates, whose models are other stages': they become this one's as
// well.
Result<Proposals> MadeForMap(const ModelSource& source, const ObjectMap& map, Proposals made) {
  std::set<ObjectId> there;
  for (const MapObject& object : map.objects) there.insert(object.id);
  std::erase_if(made.candidates,
                [&](const ShapeCandidate& candidate) { return !there.contains(candidate.object); });
  std::set<std::string> models;
  for (const ShapeCandidate& candidate : made.candidates) models.insert(candidate.model);
  std::erase_if(made.models, [&](const auto& model) { return !models.contains(model.first); });
  for (const ShapeCandidate& candidate : made.candidates) {
    if (made.models.contains(candidate.model)) continue;
    Result<VoxelGrid> grid = source.Read(candidate.source, candidate.model);
    if (!grid.ok()) return grid.error();
    made.models.emplace(candidate.model, std::move(grid).value());
  }
  return made;
}

}  // namespace

Result<ClosedMap> CloseLoops(MapWithLoops before, const LoopClosing& closing) {
  const std::vector<AppearanceLoop> appearance = std::move(before.appearance.loops);
  const std::vector<RelativePose> appearance_edges = before.appearance.edges;
  LoopWorld world = WorldOf(std::move(before));
  if (Status status = RescoreMovedApart(world.tracked, {}, closing, world); !status.ok())
    return status.error();
  Result<Loops> loops = SearchLoops(closing, world);
  if (!loops.ok()) return loops.error();
  loops->appearance = appearance;
  loops->edges.insert(loops->edges.end(), appearance_edges.begin(), appearance_edges.end());
  if (closing.sources.progress.StopRequested()) return Interrupted();
  if (Status status = DropDuplicates(closing, world); !status.ok()) return status.error();
  MoveObjects(world.odometry, world.tracked, world.map);
  Result<Proposals> made = MadeForMap(closing.sources.models, world.map, std::move(world.made));
  if (!made.ok()) return made.error();
  std::vector<CandidateRegistration> registrations = PlacedRegistrations(world);
  return ClosedMap{std::move(world.map),
                   std::move(world.association),
                   std::move(made).value(),
                   std::move(registrations),
                   std::move(loops).value()};
}

}  // namespace deepslam::modelling
