// loops: places seen again, by their appearance and by constellations of objects; the objects that
// loops join compete for their shape anew.
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/association_json.h"
#include "deepslam/artifact/loops_json.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/core/parallel.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/loop/shared_place.h"
#include "deepslam/shape/view_points.h"
#include "deepslam/stages/appearance_stage.h"
#include "deepslam/stages/judge_object.h"
#include "deepslam/stages/keyframe_graph.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/refine_object.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

constexpr int kEvidencePointsPerView = 300;
constexpr int kSurroundingsStridePx = 8;  // enough for a share; a view gives a few hundred points
constexpr float kMaxSurroundingsDepthM = 5.0F;
// Views that the loops move further against each other were judged where the object was not.
constexpr double kMovedApart_m = 0.10;

// Everything the stage reads. Where loops were closed by appearance or by objects that were known
// again, cameras, ground and objects stand where these put them.
struct LoopInputs {
  Odometry tracked;
  Odometry odometry;
  Ground ground;
  loop::AcceptedAppearance appearance;
  int num_measured_again = 0;
  Association association;
  Proposals proposals;
  ObjectMap map;
};

// How closing loops moves what this frame saw.
std::optional<Pose3> ClosedFromTracked(const Odometry& tracked,
                                       const Odometry& closed,
                                       FrameIdx frame) {
  if (!frame.valid() || frame.value >= static_cast<int>(tracked.frames.size())) return std::nullopt;
  const Pose3& before = tracked.at(frame).world_from_camera;
  const Pose3& after = closed.at(frame).world_from_camera;
  return before == after ? Pose3{} : after * before.Inverse();
}

// The same of the object's best view; an object without views stays.
Pose3 ClosedFromTracked(const Odometry& tracked, const Odometry& closed, const MapObject& object) {
  Pose3 best;
  double share = -1;
  for (const ViewRegistration& view : object.views) {
    const std::optional<Pose3> own = ClosedFromTracked(tracked, closed, view.frame);
    if (!own || view.inlier_share <= share) continue;
    share = view.inlier_share;
    best = *own;
  }
  return best;
}

// The largest distance by which `closed` moves what a view saw of the object against what its best
// view saw: views of both ends of a stretch that is corrected.
double MovedApart_m(const Odometry& tracked, const Odometry& closed, const MapObject& object) {
  const Pose3 best = ClosedFromTracked(tracked, closed, object);
  const Eigen::Vector3d centre_tracked = best.Inverse() * object.world_from_object.translation_m;
  double apart_m = 0;
  for (const ViewRegistration& view : object.views) {
    const std::optional<Pose3> own = ClosedFromTracked(tracked, closed, view.frame);
    if (own) apart_m = std::max(apart_m, (*own * centre_tracked - best * centre_tracked).norm());
  }
  return apart_m;
}

ObjectMap Moved(const Odometry& tracked, const Odometry& closed, ObjectMap map) {
  for (MapObject& object : map.objects) {
    object.world_from_object =
        ClosedFromTracked(tracked, closed, object) * object.world_from_object;
  }
  return map;
}

// Objects that were known again tie their visits together. Where that moves what was seen of one
// apart, the path is closed by them, before others are looked for along it.
Status CloseByObjects(const RunInputs& inputs,
                      const Odometry& tracked,
                      const ObjectMap& map,
                      ClosedTrajectory& closed) {
  const graph::GraphOptions& options = inputs.config.optimize;
  if (!inputs.config.loops.enabled || !options.use_objects) return Ok();
  const ObjectMap moved = Moved(tracked, closed.odometry, map);
  Result<SolvedPath> solved =
      SolvePath(closed.odometry, closed.ground, closed.appearance.edges, options, moved);
  if (!solved.ok()) return solved.error();
  Odometry by_objects = closed.odometry;
  by_objects.frames = std::move(solved->frames);
  const bool apart = std::ranges::any_of(moved.objects, [&](const MapObject& object) {
    return MovedApart_m(closed.odometry, by_objects, object) > kMovedApart_m;
  });
  if (!apart) return Ok();
  closed.odometry = std::move(by_objects);
  closed.ground = std::move(solved->ground);
  return Ok();
}

Result<LoopInputs> ReadLoopInputs(const StageContext& context, const RunInputs& inputs) {
  Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  Result<Association> association = ReadAssociation(context, "associate");
  if (!association.ok()) return association.error();
  Result<Proposals> proposals = ReadCandidates(context, "select");
  if (!proposals.ok()) return proposals.error();
  const Result<ObjectMap> map = ReadObjects(context, "select");
  if (!map.ok()) return map.error();
  Result<ClosedTrajectory> closed = CloseByAppearance(context, inputs, *odometry, *ground);
  if (!closed.ok()) return closed.error();
  if (Status status = CloseByObjects(inputs, *odometry, *map, *closed); !status.ok())
    return status.error();
  ObjectMap moved = Moved(*odometry, closed->odometry, *map);
  return LoopInputs{std::move(*odometry),
                    std::move(closed->odometry),
                    std::move(closed->ground),
                    std::move(closed->appearance),
                    closed->num_measured_again,
                    std::move(*association),
                    std::move(*proposals),
                    std::move(moved)};
}

void AppendWorld(const Pose3& world_from_camera,
                 std::span<const Eigen::Vector3f> points_camera,
                 std::vector<Eigen::Vector3f>& points_world) {
  for (const Eigen::Vector3f& p : points_camera) {
    points_world.push_back((world_from_camera * p.cast<double>()).cast<float>());
  }
}

std::vector<Eigen::Vector3f> Surroundings(const ObjectView& view) {
  std::vector<Eigen::Vector3f> points;
  for (int v = 0; v < view.depth_crop_m.height(); v += kSurroundingsStridePx) {
    for (int u = 0; u < view.depth_crop_m.width(); u += kSurroundingsStridePx) {
      const float depth_m = view.depth_crop_m(u, v);
      if (depth_m <= 0 || depth_m > kMaxSurroundingsDepthM || view.mask_crop(u, v) != 0) continue;
      points.push_back(view.camera.Unproject(u, v, depth_m).cast<float>());
    }
  }
  return points;
}

// The tracks of these objects, in their order.
template <typename Wanted>
std::vector<ObjectTrack> TracksOf(const Association& association, const Wanted& wanted) {
  std::vector<ObjectTrack> tracks;
  std::copy_if(association.tracks.begin(),
               association.tracks.end(),
               std::back_inserter(tracks),
               [&](const ObjectTrack& track) { return wanted(track.id); });
  return tracks;
}

// What the views of the batch's objects measured.
void AddMeasured(std::span<TrackViews> batch, loop::LoopEvidence& evidence) {
  std::vector<loop::ObjectEvidence*> own;
  for (const TrackViews& of_track : batch) own.push_back(&evidence[of_track.track->id]);
  ParallelFor(batch.size(), [&](std::size_t n) {
    for (const ObjectView& view : batch[n].views) {
      const shape::ViewPoints points = shape::ExtractViewPoints(view, kEvidencePointsPerView);
      AppendWorld(view.world_from_camera, points.points_camera, own[n]->depth_points_world);
      AppendWorld(view.world_from_camera, Surroundings(view), own[n]->surroundings_world);
    }
  });
}

Status ForDepthViews(const StageContext& context,
                     const RunInputs& inputs,
                     const LoopInputs& in,
                     const std::vector<ObjectTrack>& tracks,
                     const std::function<Status(std::span<TrackViews>)>& use) {
  return ForTrackViews(
      context, inputs, in.odometry, in.ground, tracks, observe::ViewContent::kDepth, use);
}

Result<loop::LoopEvidence> CollectEvidence(const StageContext& context,
                                           const RunInputs& inputs,
                                           const LoopInputs& in) {
  loop::LoopEvidence evidence;
  for (const MapObject& object : in.map.objects) evidence[object.id];
  const std::vector<ObjectTrack> tracks =
      TracksOf(in.association, [&](ObjectId id) { return evidence.contains(id); });
  const auto add = [&](std::span<TrackViews> batch) {
    AddMeasured(batch, evidence);
    return Ok();
  };
  const Status measured = ForDepthViews(context, inputs, in, tracks, add);
  if (!measured.ok()) return measured.error();
  for (const MapObject& object : in.map.objects) {
    loop::ObjectEvidence& own = evidence[object.id];
    const Result<VoxelGrid> grid = ReadModel(context, "select", object.model);
    if (!grid.ok()) return grid.error();
    const Similarity3 world_from_model =
        Similarity3::From(object.world_from_object, object.scale_m);
    const shape::ShapeModel model(*grid);
    for (const Eigen::Vector3f& p : model.surface_points()) {
      own.model_points_world.push_back((world_from_model * p.cast<double>()).cast<float>());
    }
  }
  return evidence;
}

Result<Loops> DetectLoops(const StageContext& context,
                          const RunInputs& inputs,
                          const LoopInputs& in) {
  const loop::LoopOptions& options = inputs.config.loops;
  if (!options.enabled) return Loops();
  const std::vector<Constellation> proposed =
      loop::FindConstellations(in.map, in.association, options, in.odometry);
  std::vector<Constellation> verified(proposed.size());
  if (!proposed.empty()) {  // most captures propose nothing, and evidence takes all views
    const Result<loop::LoopEvidence> evidence = CollectEvidence(context, inputs, in);
    if (!evidence.ok()) return evidence.error();
    ParallelFor(proposed.size(), [&](std::size_t i) {
      verified[i] = loop::VerifyConstellation(proposed[i], in.map, *evidence, options);
    });
  }
  return loop::AcceptLoops(verified, in.map, in.association, options, in.odometry);
}

// A step from an object to the older one that an accepted constellation paired it with.
struct Step {
  ObjectId older;
  Pose3 older_from_newer;
};

// `kept` is preferred; objects that came back twice are joined by way of the visit between.
std::optional<Step> StepFrom(const Loops& loops, ObjectId newer, ObjectId kept) {
  std::optional<Step> step;
  for (const Constellation& constellation : loops.constellations) {
    if (!constellation.accepted) continue;
    for (const ObjectMerge& pair : constellation.pairs) {
      if (pair.merged != newer) continue;
      if (!step || pair.kept == kept) step = {pair.kept, constellation.old_world_from_new_world};
    }
  }
  return step;
}

// Brings the merged object's views onto the kept one.
Pose3 CorrectionOf(const Loops& loops, const ObjectMerge& merge) {
  Pose3 kept_from_merged;
  ObjectId current = merge.merged;
  for (std::size_t n = 0; n < loops.constellations.size() && current != merge.kept; ++n) {
    const std::optional<Step> step = StepFrom(loops, current, merge.kept);
    if (!step) break;
    kept_from_merged = step->older_from_newer * kept_from_merged;
    current = step->older;
  }
  return kept_from_merged;
}

ObjectTrack* FindTrack(Association& association, ObjectId id) {
  const auto it = std::find_if(association.tracks.begin(),
                               association.tracks.end(),
                               [&](const ObjectTrack& track) { return track.id == id; });
  return it == association.tracks.end() ? nullptr : &*it;
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

// The merged object's members, views and candidates become the kept one's; its views move by the
// loop's correction.
void Merge(const ObjectMerge& merge,
           const Pose3& correction,
           LoopInputs& in,
           ViewOrigins& origins) {
  ObjectTrack* kept = FindTrack(in.association, merge.kept);
  const ObjectTrack* merged = FindTrack(in.association, merge.merged);
  if (kept == nullptr || merged == nullptr) return;
  for (TrackMember member : merged->members) {
    member.how = "merge";
    kept->members.push_back(std::move(member));
  }
  std::stable_sort(kept->members.begin(),
                   kept->members.end(),
                   [](const TrackMember& a, const TrackMember& b) { return a.frame < b.frame; });
  std::erase_if(in.association.tracks,
                [&](const ObjectTrack& track) { return track.id == merge.merged; });
  std::vector<ViewOrigin> moved = OriginsOf(merge.merged, origins);
  std::vector<ViewOrigin>& kept_origins = OriginsOf(merge.kept, origins);
  for (ViewOrigin& origin : moved) {
    origin.corrections.push_back(correction);
    kept_origins.push_back(std::move(origin));
  }
  for (ShapeCandidate& candidate : in.proposals.candidates) {
    if (candidate.object == merge.merged) candidate.object = merge.kept;
  }
}

// The views of an object after merging, ascending frames. `tracks` are those before merging.
Result<std::vector<ObjectView>> MergedViews(const StageContext& context,
                                            const RunInputs& inputs,
                                            const LoopInputs& in,
                                            const Association& before,
                                            std::span<const ViewOrigin> origins) {
  ObjectViews of_tracks;
  const std::vector<ObjectTrack> tracks = TracksOf(before, [&](ObjectId id) {
    return std::any_of(origins.begin(), origins.end(), [&](const ViewOrigin& origin) {
      return origin.track == id;
    });
  });
  const auto keep = [&](std::span<TrackViews> batch) {
    for (TrackViews& of_track : batch) of_tracks[of_track.track->id] = std::move(of_track.views);
    return Ok();
  };
  const Status status = ForDepthViews(context, inputs, in, tracks, keep);
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

struct Reselection {
  ObjectMap map;
  Proposals made;  // candidates added here
  // Of all candidates of the objects judged anew, in the tracking world.
  std::vector<CandidateRegistration> registrations;
};

struct Judged {
  MapObject object;
  std::vector<CandidateRegistration> registrations;
};

// The object as its candidates, registered and judged by all these views and completed anew, make
// it. `change` names what is completed here.
Result<Judged> JudgeAnew(const StageContext& context,
                         const RunInputs& inputs,
                         const LoopInputs& in,
                         const MapObject& object,
                         std::span<const ObjectView> views,
                         std::string_view change,
                         int first_made,
                         Proposals& made) {
  Contest contest{
      object.id, object.class_name, CandidatesOf(in.proposals, object.id), {}, {}, {}, {}};
  Result<ModelMap> models = LoadModels(context, contest.candidates);
  if (!models.ok()) return models.error();
  contest.models = std::move(models).value();
  contest.registrations =
      RegisterAll(contest.candidates, contest.models, views, inputs.config.registration);
  ScoreAll(views, inputs.config.select, contest);
  if (inputs.config.shape_refinement.complete) {
    Proposals completed = CompleteBest(contest, views, change, inputs);
    Enter(std::move(completed), views, inputs, first_made, contest, made);
  }
  std::vector<std::string> applied;  // told by stage select already
  Result<MapObject> selected = SelectOrChoose(contest, views, inputs, applied);
  if (!selected.ok()) return selected.error();
  // Nothing fits all views: what fitted the old ones stays.
  const bool fits = selected->chosen.valid();
  return Judged{fits ? std::move(selected).value() : object, std::move(contest.registrations)};
}

// As the stages before have them: the tracking world about the object's best view.
void KeepRegistrations(const LoopInputs& in, Judged& judged, Reselection& reselection) {
  const Pose3 tracked_from_closed =
      ClosedFromTracked(in.tracked, in.odometry, judged.object).Inverse();
  for (CandidateRegistration& registration : judged.registrations) {
    registration.world_from_object = tracked_from_closed * registration.world_from_object;
    reselection.registrations.push_back(std::move(registration));
  }
}

// Objects that are one from now on, and those whose views the loops move apart, are registered and
// selected with everything that was seen of them; the others stay as they are.
Result<Reselection> Reselect(const StageContext& context,
                             const RunInputs& inputs,
                             const Loops& loops,
                             LoopInputs& in) {
  std::map<ObjectId, std::vector<ObjectId>> groups;
  std::set<ObjectId> gone;
  const Association before = in.association;
  ViewOrigins origins;
  for (const ObjectMerge& merge : loops.merges) {
    Merge(merge, CorrectionOf(loops, merge), in, origins);
    groups[merge.kept].push_back(merge.merged);
    gone.insert(merge.merged);
  }
  const int first_made = NextId(in.proposals);
  Reselection reselection;
  ObjectMap& map = reselection.map;
  map.dropped = in.map.dropped;
  for (const MapObject& object : in.map.objects) {
    if (gone.contains(object.id)) continue;
    const bool merged = groups.contains(object.id);
    if (!merged && MovedApart_m(in.tracked, in.odometry, object) <= kMovedApart_m) {
      map.objects.push_back(object);
      continue;
    }
    const Result<std::vector<ObjectView>> views =
        MergedViews(context, inputs, in, before, OriginsOf(object.id, origins));
    if (!views.ok()) return views.error();
    Result<Judged> judged = JudgeAnew(context,
                                      inputs,
                                      in,
                                      object,
                                      *views,
                                      merged ? "merged" : "closed",
                                      first_made,
                                      reselection.made);
    if (!judged.ok()) return judged.error();
    KeepRegistrations(in, *judged, reselection);
    if (merged) judged->object.merged = groups.at(object.id);
    map.objects.push_back(std::move(judged->object));
  }
  return reselection;
}

// Objects that stand in a surer one leave the map, and the map says so.
void DropIntruders(const loop::LoopOptions& options, ObjectMap& map) {
  const std::vector<loop::Intruder> intruders = loop::FindIntruders(map, options);
  std::map<ObjectId, std::string> names;
  for (const MapObject& object : map.objects) names[object.id] = ObjectName(object);
  for (const loop::Intruder& intruder : intruders) {
    map.dropped.push_back(
        fmt::format("{}: stands in {}, which is surer", names[intruder.id], names[intruder.host]));
    std::erase_if(map.objects, [&](const MapObject& object) { return object.id == intruder.id; });
  }
}

void AddAppearance(const loop::AcceptedAppearance& appearance, Loops& loops) {
  loops.appearance = appearance.loops;
  loops.edges.insert(loops.edges.end(), appearance.edges.begin(), appearance.edges.end());
}

}  // namespace

Result<StageSummary> RunLoops(StageContext& context, const RunInputs& inputs) {
  Result<LoopInputs> in = ReadLoopInputs(context, inputs);
  if (!in.ok()) return in.error();
  Result<Loops> detected = DetectLoops(context, inputs, *in);
  if (!detected.ok()) return detected.error();
  Loops loops = std::move(detected).value();
  AddAppearance(in->appearance, loops);
  if (context.progress().StopRequested()) return Interrupted();
  Result<Reselection> reselection = Reselect(context, inputs, loops, *in);
  if (!reselection.ok()) return reselection.error();
  ObjectMap& map = reselection->map;
  DropIntruders(inputs.config.loops, map);
  for (MapObject& object : map.objects) {
    object.world_from_object =
        ClosedFromTracked(in->tracked, in->odometry, object).Inverse() * object.world_from_object;
  }
  const std::vector<std::pair<std::string_view, Result<std::string>>> files = {
      {"loops.json", artifact::EncodeLoops(loops, "loops.json")},
      {"objects.json", artifact::EncodeObjectMap(map, "objects.json")},
      {"candidates.json", artifact::EncodeProposals(reselection->made, "candidates.json")},
      {"registrations.json",
       artifact::EncodeRegistrations(reselection->registrations, "registrations.json")},
      {"tracks.json", artifact::EncodeAssociation(in->association, "tracks.json")}};
  for (const auto& [file, text] : files) {
    if (Status status = WriteEncoded(context, file, text); !status.ok()) return status.error();
  }
  if (Status status = WriteModels(context, reselection->made.models); !status.ok())
    return status.error();
  if (Status status = CopyChosenModels(context, map, reselection->made.models); !status.ok())
    return status.error();
  const auto accepted =
      std::count_if(loops.constellations.begin(),
                    loops.constellations.end(),
                    [](const Constellation& constellation) { return constellation.accepted; });
  const auto seen_again = std::count_if(
      loops.appearance.begin(), loops.appearance.end(), [](const AppearanceLoop& appearance) {
        return appearance.accepted;
      });
  return StageSummary{
      fmt::format("{} of {} constellations and {} of {} loops by appearance accepted, {} "
                  "neighbours measured again, {} objects merged, {} edges; {} objects",
                  accepted,
                  loops.constellations.size(),
                  seen_again,
                  loops.appearance.size(),
                  in->num_measured_again,
                  loops.merges.size(),
                  loops.edges.size(),
                  map.objects.size()),
      {{"num_accepted", static_cast<double>(accepted)},
       {"num_appearance", static_cast<double>(seen_again)},
       {"num_measured_again", static_cast<double>(in->num_measured_again)},
       {"num_merges", static_cast<double>(loops.merges.size())},
       {"num_edges", static_cast<double>(loops.edges.size())},
       {"num_objects", static_cast<double>(map.objects.size())}}};
}

}  // namespace deepslam::stages
