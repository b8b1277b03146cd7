#include "deepslam/modelling/merge_objects.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "deepslam/loop/merge_correction.h"
#include "deepslam/modelling/rescore_objects.h"

namespace deepslam::modelling {
namespace {

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

void MergeTracks(const ObjectMerge& merge, Association& association) {
  ObjectTrack* const kept = FindTrack(association, merge.kept);
  const ObjectTrack* const merged = FindTrack(association, merge.merged);
  if (merged->members.size() > kept->members.size()) kept->class_name = merged->class_name;
  for (const auto& [name, votes] : merged->class_votes) kept->class_votes[name] += votes;
  for (TrackMember member : merged->members) {
    member.how = "merge";
    kept->members.push_back(std::move(member));
  }
  std::ranges::stable_sort(kept->members, {}, &TrackMember::frame);
  EraseTrack(association, merge.merged);
}

// The merged object's members, views and candidates become the kept one's; its views move by the
// loop's correction.
void Merge(const ObjectMerge& merge,
           const Pose3& correction,
           LoopWorld& world,
           ViewOrigins& origins) {
  if (FindTrack(world.association, merge.kept) == nullptr ||
      FindTrack(world.association, merge.merged) == nullptr)
    return;
  MergeTracks(merge, world.association);
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

// The views of an object after merging, ascending frames. `before`: the tracks before it.
Result<std::vector<ObjectView>> ViewsOf(std::span<const ViewOrigin> origins,
                                        const Association& before,
                                        const LoopWorld& world,
                                        const ViewSource& source) {
  std::vector<ObjectTrack> tracks;
  for (const ObjectTrack& track : before.tracks) {
    if (std::ranges::find(origins, track.id, &ViewOrigin::track) != origins.end())
      tracks.push_back(track);
  }
  std::map<ObjectId, std::vector<ObjectView>> of_tracks;
  const auto keep = [&](std::span<TrackViews> batch) {
    for (TrackViews& of_track : batch) of_tracks[of_track.track->id] = std::move(of_track.views);
    return Ok();
  };
  const Status status =
      source.ForBatches({tracks, world.odometry, world.ground}, observe::ViewContent::kDepth, keep);
  if (!status.ok()) return status.error();
  std::vector<ObjectView> views;
  for (const ViewOrigin& origin : origins) {
    for (ObjectView& view : of_tracks[origin.track]) {
      for (const Pose3& correction : origin.corrections)
        view.world_from_camera = correction * view.world_from_camera;
      views.push_back(std::move(view));
    }
  }
  std::ranges::stable_sort(views, {}, &ObjectView::frame);
  return views;
}

}  // namespace

Status MergeObjects(const Loops& found, const LoopClosing& closing, LoopWorld& world) {
  const Association before = world.association;
  std::map<ObjectId, std::vector<ObjectId>> groups;
  ViewOrigins origins;
  for (const ObjectMerge& merge : found.merges) {
    Merge(merge, loop::CorrectionOf(merge, found), world, origins);
    std::vector<ObjectId>& group = groups[merge.kept];
    group.push_back(merge.merged);
    const MapObject* const gone = FindObject(world.map, merge.merged);
    if (gone == nullptr) continue;
    std::ranges::copy(gone->merged, std::back_inserter(group));
    std::erase_if(world.map.objects,
                  [&](const MapObject& object) { return object.id == merge.merged; });
    world.registrations.erase(merge.merged);
  }
  for (MapObject& object : world.map.objects) {
    const auto group = groups.find(object.id);
    if (group == groups.end()) continue;
    object.class_name = FindTrack(world.association, object.id)->class_name;
    object.class_votes = FindTrack(world.association, object.id)->class_votes;
    const Result<std::vector<ObjectView>> views =
        ViewsOf(OriginsOf(object.id, origins), before, world, closing.sources.views);
    if (!views.ok()) return views.error();
    if (Status status = Rescore({*views, "merged"}, closing, world, object); !status.ok())
      return status;
    std::ranges::copy(group->second, std::back_inserter(object.merged));
    std::ranges::sort(object.merged);
  }
  return Ok();
}

}  // namespace deepslam::modelling
