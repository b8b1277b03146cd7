#include "deepslam/stages/loop_world.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "deepslam/loop/merge_correction.h"
#include "deepslam/stages/judge_object.h"
#include "deepslam/stages/refine_object.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;

std::optional<Pose3> AfterFromBefore(const Trajectory& before,
                                     const Trajectory& after,
                                     FrameIdx frame) {
  if (!frame.valid() || frame.value >= static_cast<int>(before.frames.size())) return std::nullopt;
  const Pose3& from = before.at(frame).world_from_camera;
  const Pose3& to = after.at(frame).world_from_camera;
  return from == to ? Pose3{} : to * from.Inverse();
}

// Whose views an object has after merging: those of its own track, then of each that was merged
// into it, with the corrections that move them, the first one first.
struct ViewOrigin {
  ObjectId track;
  std::vector<Pose3> corrections;
};
using ViewOrigins = std::map<ObjectId, std::vector<ViewOrigin>>;

std::vector<ViewOrigin>& OriginsOf(ObjectId id, ViewOrigins& origins) {
  std::vector<ViewOrigin>& own = origins[id];
  if (own.empty()) own.push_back({id, {}});
  return own;
}

ObjectTrack* FindTrack(Association& association, ObjectId id) {
  const auto it = std::find_if(association.tracks.begin(),
                               association.tracks.end(),
                               [&](const ObjectTrack& track) { return track.id == id; });
  return it == association.tracks.end() ? nullptr : &*it;
}

void EraseTrack(Association& association, ObjectId id) {
  std::erase_if(association.tracks, [&](const ObjectTrack& track) { return track.id == id; });
}

void SortTracks(Association& association) {
  std::ranges::stable_sort(association.tracks, {}, &ObjectTrack::id);
}

// The merged object's members, views and candidates become the kept one's; its views move by the
// loop's correction. Of two classes the one that was seen more often stays.
void Merge(const ObjectMerge& merge,
           const Pose3& correction,
           LoopWorld& world,
           ViewOrigins& origins) {
  ObjectTrack* kept = FindTrack(world.association, merge.kept);
  const ObjectTrack* merged = FindTrack(world.association, merge.merged);
  if (kept == nullptr || merged == nullptr) return;
  if (merged->members.size() > kept->members.size()) kept->class_name = merged->class_name;
  for (TrackMember member : merged->members) {
    member.how = "merge";
    kept->members.push_back(std::move(member));
  }
  std::stable_sort(kept->members.begin(),
                   kept->members.end(),
                   [](const TrackMember& a, const TrackMember& b) { return a.frame < b.frame; });
  EraseTrack(world.association, merge.merged);
  std::vector<ViewOrigin> moved = OriginsOf(merge.merged, origins);
  std::vector<ViewOrigin>& kept_origins = OriginsOf(merge.kept, origins);
  for (ViewOrigin& origin : moved) {
    origin.corrections.push_back(correction);
    kept_origins.push_back(std::move(origin));
  }
  for (Proposals* proposals : {&world.proposals, &world.made}) {
    for (ShapeCandidate& candidate : proposals->candidates) {
      if (candidate.object == merge.merged) candidate.object = merge.kept;
    }
  }
}

// The views of an object after merging, ascending frames. `tracks` are those before merging.
Result<std::vector<ObjectView>> ViewsOf(const StageContext& context,
                                        const RunInputs& inputs,
                                        const LoopWorld& world,
                                        const Association& before,
                                        std::span<const ViewOrigin> origins) {
  ObjectViews of_tracks;
  std::vector<ObjectTrack> tracks;
  for (const ObjectTrack& track : before.tracks) {
    if (std::ranges::find(origins, track.id, &ViewOrigin::track) != origins.end())
      tracks.push_back(track);
  }
  const auto keep = [&](std::span<TrackViews> batch) {
    for (TrackViews& of_track : batch) of_tracks[of_track.track->id] = std::move(of_track.views);
    return Ok();
  };
  const Status status = ForDepthViews(context, inputs, world, tracks, keep);
  if (!status.ok()) return status.error();
  std::vector<ObjectView> views;
  for (const ViewOrigin& origin : origins) {
    for (ObjectView& view : of_tracks[origin.track]) {
      for (const Pose3& correction : origin.corrections)
        view.world_from_camera = correction * view.world_from_camera;
      views.push_back(std::move(view));
    }
  }
  std::stable_sort(views.begin(), views.end(), [](const ObjectView& a, const ObjectView& b) {
    return a.frame < b.frame;
  });
  return views;
}

std::vector<ShapeCandidate> AllCandidatesOf(const LoopWorld& world, ObjectId object) {
  std::vector<ShapeCandidate> candidates = CandidatesOf(world.proposals, object);
  std::ranges::move(CandidatesOf(world.made, object), std::back_inserter(candidates));
  return candidates;
}

// What is completed for an object goes by `change`, with a number from the second time on.
std::string NextName(std::string_view change, ObjectId object, LoopWorld& world) {
  const int n = ++world.num_judged[object];
  return n == 1 ? std::string(change) : fmt::format("{}{}", change, n);
}

// The object as its candidates, registered and judged by all these views and completed anew, make
// it. Where nothing fits all views, what fitted the old ones stays.
Status JudgeAnew(const StageContext& context,
                 const RunInputs& inputs,
                 std::span<const ObjectView> views,
                 std::string_view change,
                 LoopWorld& world,
                 MapObject& object) {
  Contest contest{object.id, object.class_name, AllCandidatesOf(world, object.id), {}, {}, {}, {}};
  Result<ModelMap> models = LoadModels(context, inputs, contest.candidates, world.made.models);
  if (!models.ok()) return models.error();
  contest.models = std::move(models).value();
  contest.registrations =
      RegisterAll(contest.candidates, contest.models, views, inputs.config.registration);
  ScoreAll(views, inputs.config.select, contest);
  if (inputs.config.shape_refinement.complete) {
    Proposals completed = CompleteBest(contest, views, NextName(change, object.id, world), inputs);
    Enter(std::move(completed), views, inputs, NextId(world.proposals), contest, world.made);
  }
  RefineWinner(views, inputs, contest);
  std::vector<std::string> applied;  // told by stage select already
  Result<MapObject> selected = SelectOrChoose(contest, views, inputs, applied);
  if (!selected.ok()) return selected.error();
  if (selected->chosen.valid()) {
    selected->merged = std::move(object.merged);
    object = std::move(selected).value();
  }
  world.registrations[object.id] = std::move(contest.registrations);
  return Ok();
}

// By all views of its track.
Status JudgeWhole(const StageContext& context,
                  const RunInputs& inputs,
                  std::string_view change,
                  LoopWorld& world,
                  MapObject& object) {
  const std::vector<ViewOrigin> own = {{object.id, {}}};
  const Result<std::vector<ObjectView>> views =
      ViewsOf(context, inputs, world, world.association, own);
  if (!views.ok()) return views.error();
  return JudgeAnew(context, inputs, *views, change, world, object);
}

void CopyCandidates(ObjectId from, ObjectId to, LoopWorld& world) {
  const int first = NextId(world.proposals);
  for (ShapeCandidate candidate : CandidatesOf(world.proposals, from)) {
    candidate.object = to;
    candidate.id = CandidateId{first + static_cast<int>(world.made.candidates.size())};
    world.made.candidates.push_back(std::move(candidate));
  }
}

// The object with what one of its visits saw.
MapObject OfVisit(const MapObject& object, const ObjectTrack& visit) {
  MapObject own = object;
  own.id = visit.id;
  own.merged.clear();
  std::erase_if(own.views, [&](const ViewRegistration& view) {
    return view.frame < visit.members.front().frame || view.frame > visit.members.back().frame;
  });
  return own;
}

void Remove(ObjectId visit, LoopWorld& world) {
  EraseTrack(world.association, visit);
  std::erase_if(world.map.objects, [&](const MapObject& object) { return object.id == visit; });
  world.registrations.erase(visit);
  for (ShapeCandidate& candidate : world.made.candidates) {
    if (candidate.object == visit) candidate.object = ObjectId();
  }
}

}  // namespace

Pose3 MovedWith(const Trajectory& before, const Trajectory& after, const MapObject& object) {
  Pose3 best;
  double share = -1;
  for (const ViewRegistration& view : object.views) {
    const std::optional<Pose3> own = AfterFromBefore(before, after, view.frame);
    if (!own || view.inlier_share <= share) continue;
    share = view.inlier_share;
    best = *own;
  }
  return best;
}

double MovedApart_m(const Trajectory& before,
                    const Trajectory& after,
                    const MapObject& object,
                    const Eigen::Vector3d& centre) {
  const Pose3 best = MovedWith(before, after, object);
  double apart_m = 0;
  for (const ViewRegistration& view : object.views) {
    const std::optional<Pose3> own = AfterFromBefore(before, after, view.frame);
    if (own) apart_m = std::max(apart_m, (*own * centre - best * centre).norm());
  }
  return apart_m;
}

void MoveObjects(const Trajectory& before, const Trajectory& after, ObjectMap& map) {
  for (MapObject& object : map.objects)
    object.world_from_object = MovedWith(before, after, object) * object.world_from_object;
}

std::vector<CandidateRegistration> PlacedRegistrations(const LoopWorld& world) {
  std::vector<CandidateRegistration> placed;
  for (const MapObject& object : world.map.objects) {
    const auto own = world.registrations.find(object.id);
    if (own == world.registrations.end()) continue;
    const auto chosen =
        std::ranges::find(own->second, object.chosen, &CandidateRegistration::candidate);
    const Pose3 now_from_then =
        chosen == own->second.end() || !chosen->ok
            ? Pose3{}
            : object.world_from_object * chosen->world_from_object.Inverse();
    for (CandidateRegistration registration : own->second) {
      registration.world_from_object = now_from_then * registration.world_from_object;
      placed.push_back(std::move(registration));
    }
  }
  return placed;
}

Status ForDepthViews(const StageContext& context,
                     const RunInputs& inputs,
                     const LoopWorld& world,
                     std::span<const ObjectTrack> tracks,
                     const std::function<Status(std::span<TrackViews>)>& use) {
  return ForTrackViews(context,
                       inputs,
                       *world.segments,
                       world.odometry,
                       world.ground,
                       tracks,
                       observe::ViewContent::kDepth,
                       use);
}

Result<VoxelGrid> ReadChosenModel(const StageContext& context,
                                  const LoopWorld& world,
                                  const MapObject& object) {
  const auto made = world.made.models.find(object.model);
  if (made != world.made.models.end()) return made->second;
  return ReadModel(context, StageOfModel(object.source), object.model);
}

Status JudgeMerged(const StageContext& context,
                   const RunInputs& inputs,
                   const Loops& found,
                   LoopWorld& world) {
  const Association before = world.association;
  std::map<ObjectId, std::vector<ObjectId>> groups;
  ViewOrigins origins;
  for (const ObjectMerge& merge : found.merges) {
    Merge(merge, loop::CorrectionOf(merge, found), world, origins);
    groups[merge.kept].push_back(merge.merged);
    const auto gone = std::ranges::find(world.map.objects, merge.merged, &MapObject::id);
    if (gone == world.map.objects.end()) continue;
    std::ranges::copy(gone->merged, std::back_inserter(groups[merge.kept]));
    world.map.objects.erase(gone);
    world.registrations.erase(merge.merged);
  }
  for (MapObject& object : world.map.objects) {
    const auto group = groups.find(object.id);
    if (group == groups.end()) continue;
    object.class_name = FindTrack(world.association, object.id)->class_name;
    const Result<std::vector<ObjectView>> views =
        ViewsOf(context, inputs, world, before, OriginsOf(object.id, origins));
    if (!views.ok()) return views.error();
    if (Status status = JudgeAnew(context, inputs, *views, "merged", world, object); !status.ok())
      return status;
    std::ranges::copy(group->second, std::back_inserter(object.merged));
    std::ranges::sort(object.merged);
  }
  return Ok();
}

Status JudgeMovedApart(const StageContext& context,
                       const RunInputs& inputs,
                       const Trajectory& before,
                       const std::set<ObjectId>& just_judged,
                       LoopWorld& world) {
  for (MapObject& object : world.map.objects) {
    if (just_judged.contains(object.id)) continue;
    const Eigen::Vector3d centre = MovedWith(before, world.odometry, object).Inverse() *
                                   object.world_from_object.translation_m;
    if (MovedApart_m(before, world.odometry, object, centre) <= loop::kApart_m) continue;
    if (Status status = JudgeWhole(context, inputs, "closed", world, object); !status.ok())
      return status;
  }
  return Ok();
}

Result<PartedWorld> Part(const StageContext& context,
                         const RunInputs& inputs,
                         const loop::PartedObjects& parted,
                         LoopWorld& world) {
  PartedWorld whole{world.odometry, parted.visits, {}, {}};
  std::vector<MapObject> visits;
  for (std::size_t k = 0; k < parted.visits.size(); ++k) {
    const ObjectId id = parted.visits[k].object;
    if (!whole.objects.contains(id)) {
      const auto object = std::ranges::find(world.map.objects, id, &MapObject::id);
      whole.objects.emplace(id, *object);
      whole.tracks.emplace(id, *FindTrack(world.association, id));
      world.map.objects.erase(object);
      EraseTrack(world.association, id);
    }
    if (parted.tracks[k].id != id) CopyCandidates(id, parted.tracks[k].id, world);
    world.association.tracks.push_back(parted.tracks[k]);
    visits.push_back(OfVisit(whole.objects.at(id), parted.tracks[k]));
  }
  SortTracks(world.association);
  for (MapObject& visit : visits) {
    if (Status status = JudgeWhole(context, inputs, "visit", world, visit); !status.ok())
      return status.error();
  }
  std::ranges::move(visits, std::back_inserter(world.map.objects));
  std::ranges::stable_sort(world.map.objects, {}, &MapObject::id);
  return whole;
}

Status Rejoin(const StageContext& context,
              const RunInputs& inputs,
              const std::set<ObjectId>& whole,
              const PartedWorld& parted,
              LoopWorld& world) {
  for (const PartedVisit& visit : parted.visits) {
    if (whole.contains(visit.object)) Remove(visit.visit, world);
  }
  for (const ObjectId id : whole) {
    world.association.tracks.push_back(parted.tracks.at(id));
    SortTracks(world.association);
    const MapObject& before = parted.objects.at(id);
    MapObject object = before;
    object.world_from_object =
        MovedWith(parted.trajectory, world.odometry, before) * before.world_from_object;
    const Eigen::Vector3d& centre = before.world_from_object.translation_m;
    if (MovedApart_m(parted.trajectory, world.odometry, before, centre) > loop::kApart_m) {
      if (Status status = JudgeWhole(context, inputs, "closed", world, object); !status.ok())
        return status;
    }
    world.map.objects.push_back(std::move(object));
  }
  std::ranges::stable_sort(world.map.objects, {}, &MapObject::id);
  return Ok();
}

}  // namespace deepslam::stages
