#include "deepslam/modelling/rescore_objects.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/loop/tracklets.h"
#include "deepslam/modelling/candidate_set.h"
#include "deepslam/modelling/moved_objects.h"
#include "deepslam/modelling/refine_candidates.h"

namespace deepslam::modelling {
namespace {

std::vector<ShapeCandidate> AllCandidatesOf(const LoopWorld& world, ObjectId object) {
  std::vector<ShapeCandidate> candidates = CandidatesOf(world.proposals, object);
  std::ranges::move(CandidatesOf(world.made, object), std::back_inserter(candidates));
  return candidates;
}

std::string NextName(std::string_view change, ObjectId object, LoopWorld& world) {
  const int n = ++world.num_rescored[object];
  return n == 1 ? std::string(change) : fmt::format("{}{}", change, n);
}

// The candidates of the object placed and scored by the views, the completed one among them.
Result<CandidateSet> ScoredBy(const NewViews& now,
                              const LoopClosing& closing,
                              LoopWorld& world,
                              const MapObject& object) {
  const ObjectOptions& options = closing.objects;
  CandidateSet set;
  set.object = object.id;
  set.class_name = object.class_name;
  set.candidates = AllCandidatesOf(world, object.id);
  Result<ModelMap> models = LoadModels(
      set.candidates, closing.sources.models, closing.sources.prepared, world.made.models);
  if (!models.ok()) return models.error();
  set.models = std::move(models).value();
  set.registrations = RegisterAll(set.candidates, set.models, now.views, set.class_name, options);
  ScoreAll(now.views, options, set);
  if (options.refinement.complete) {
    Proposals completed =
        CompleteBest(set, now.views, NextName(now.change, object.id, world), options);
    NumberFrom(NextId(world.proposals) + static_cast<int>(world.made.candidates.size()), completed);
    AddCandidates(completed, now.views, options, closing.sources.prepared, set);
    Append(std::move(completed), world.made);
  }
  RefineWinner(now.views, options, set);
  return set;
}

}  // namespace

Status Rescore(const NewViews& now,
               const LoopClosing& closing,
               LoopWorld& world,
               MapObject& object) {
  Result<CandidateSet> set = ScoredBy(now, closing, world, object);
  if (!set.ok()) return set.error();
  std::vector<std::string> applied;  // reported by stage select already
  Result<MapObject> selected = SelectOrChoose(*set, now.views, closing.objects, applied);
  if (!selected.ok()) return selected.error();
  if (selected->chosen.valid()) {
    selected->merged = std::move(object.merged);
    selected->class_votes = std::move(object.class_votes);
    object = std::move(selected).value();
  }
  world.registrations[object.id] = std::move(set->registrations);
  return Ok();
}

Status RescoreTrack(std::string_view change,
                    const LoopClosing& closing,
                    LoopWorld& world,
                    MapObject& object) {
  std::vector<ObjectView> views;
  if (const ObjectTrack* const track = FindTrack(world.association, object.id)) {
    const auto keep = [&](std::span<TrackViews> batch) {
      for (TrackViews& of_track : batch) views = std::move(of_track.views);
      return Ok();
    };
    const Status status = closing.sources.views.ForBatches(
        {{track, 1}, world.odometry, world.ground}, observe::ViewContent::kDepth, keep);
    if (!status.ok()) return status;
  }
  return Rescore({views, change}, closing, world, object);
}

Status RescoreMovedApart(const Trajectory& before,
                         const std::set<ObjectId>& just_scored,
                         const LoopClosing& closing,
                         LoopWorld& world) {
  for (MapObject& object : world.map.objects) {
    if (just_scored.contains(object.id)) continue;
    const Eigen::Vector3d centre = MovedWith(before, world.odometry, object).Inverse() *
                                   object.world_from_object.translation_m;
    if (MovedApart_m(before, world.odometry, object, centre) <= loop::kApart_m) continue;
    if (Status status = RescoreTrack("closed", closing, world, object); !status.ok()) return status;
  }
  return Ok();
}

}  // namespace deepslam::modelling
