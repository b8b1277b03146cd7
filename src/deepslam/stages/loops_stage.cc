// loops: places seen again, by their appearance and by constellations of objects; the objects that
// loops join compete for their shape anew.
#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <string>
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
#include "deepslam/loop/correction.h"
#include "deepslam/loop/shared_place.h"
#include "deepslam/loop/visits.h"
#include "deepslam/mapping/close_by_appearance.h"
#include "deepslam/mapping/keyframe_graph.h"
#include "deepslam/scene/measured_parts.h"
#include "deepslam/shape/view_points.h"
#include "deepslam/stages/loop_world.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/prepared_models.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

constexpr int kEvidencePointsPerView = 300;
constexpr int kSurroundingsStridePx = 8;  // enough for a share; a view gives a few hundred points
constexpr float kMaxSurroundingsDepthM = 5.0F;
// Every pass closes the path further; what two passes leave, a third seldom finds.
constexpr int kMaxPasses = 6;

mapping::AppearanceClosing ClosingOptions(const Config& config) {
  mapping::AppearanceClosing options{
      config.appearance, config.track.alignment, config.optimize, false};
  options.appearance.enabled &= config.loops.enabled;
  options.by_depth_alone =
      config.track_stage.poses != "capture" && !config.track.alignment.photometric;
  return options;
}

// Cameras and ground as loops by appearance close them, and objects where that puts them, judged
// anew where it moves their views apart.
Result<LoopWorld> ReadWorld(const StageContext& context,
                            const RunInputs& inputs,
                            mapping::ClosedTrajectory& closed) {
  LoopWorld world;
  Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  world.odometry = std::move(odometry).value();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  Result<Association> association = ReadAssociation(context, "associate");
  if (!association.ok()) return association.error();
  world.association = std::move(association).value();
  Result<Proposals> proposals = ReadCandidates(context, "select");
  if (!proposals.ok()) return proposals.error();
  world.proposals = std::move(proposals).value();
  Result<ObjectMap> map = ReadObjects(context, "select");
  if (!map.ok()) return map.error();
  world.map = std::move(map).value();
  Result<mapping::ClosedTrajectory> by_appearance =
      mapping::CloseByAppearance(*inputs.capture->frames,
                                 world.odometry,
                                 *ground,
                                 ClosingOptions(inputs.config),
                                 context.progress());
  if (!by_appearance.ok()) return by_appearance.error();
  closed = std::move(by_appearance).value();
  world.tracked = static_cast<const Trajectory&>(world.odometry);
  world.odometry.frames = closed.frames;
  world.ground = closed.ground;
  world.edges = closed.appearance.edges;
  auto segments = ShelvedSegments::Read(context);
  if (!segments.ok()) return segments.error();
  world.segments = std::move(segments).value();
  MoveObjects(world.tracked, world.odometry, world.map);
  const Status judged = JudgeMovedApart(context, inputs, world.tracked, {}, world);
  if (!judged.ok()) return judged.error();
  return world;
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

// What the views measured of the object and around it.
void Append(std::span<const ObjectView> views, loop::ObjectEvidence& evidence) {
  std::vector<std::vector<Eigen::Vector3f>> points(views.size());
  std::vector<std::vector<Eigen::Vector3f>> surroundings(views.size());
  ParallelFor(views.size(), [&](std::size_t n) {
    points[n] = shape::ExtractViewPoints(views[n], kEvidencePointsPerView).points_camera;
    surroundings[n] = Surroundings(views[n]);
  });
  for (std::size_t n = 0; n < views.size(); ++n) {
    AppendWorld(views[n].world_from_camera, points[n], evidence.depth_points_world);
    AppendWorld(views[n].world_from_camera, surroundings[n], evidence.surroundings_world);
  }
}

// Of these objects of the map.
Result<loop::LoopEvidence> CollectEvidence(const StageContext& context,
                                           const RunInputs& inputs,
                                           const LoopWorld& world,
                                           const std::set<ObjectId>& wanted) {
  loop::LoopEvidence evidence;
  for (const ObjectId id : wanted) evidence[id];
  std::vector<ObjectTrack> tracks;
  std::ranges::copy_if(world.association.tracks,
                       std::back_inserter(tracks),
                       [&](const ObjectTrack& track) { return evidence.contains(track.id); });
  const auto add = [&](std::span<TrackViews> batch) {
    ParallelFor(batch.size(),
                [&](std::size_t n) { Append(batch[n].views, evidence.at(batch[n].track->id)); });
    return Ok();
  };
  const Status measured = ForDepthViews(context, inputs, world, tracks, add);
  if (!measured.ok()) return measured.error();
  for (const MapObject& object : world.map.objects) {
    if (!wanted.contains(object.id)) continue;
    loop::ObjectEvidence& own = evidence[object.id];
    const Result<VoxelGrid> grid = ReadChosenModel(context, world, object);
    if (!grid.ok()) return grid.error();
    const Similarity3 world_from_model =
        Similarity3::From(object.world_from_object, object.scale_m);
    const PreparedModel model = Prepared(inputs, object.model, *grid);
    for (const Eigen::Vector3f& p : model->surface_points()) {
      own.model_points_world.push_back((world_from_model * p.cast<double>()).cast<float>());
    }
  }
  return evidence;
}

// With what loops have measured so far.
std::vector<int> PartsOf(const LoopWorld& world) {
  return PartsOfFrames(world.odometry, JoinsOf(world.odometry, world.edges));
}

Result<Loops> DetectLoops(const StageContext& context,
                          const RunInputs& inputs,
                          const std::vector<PartedVisit>& visits,
                          const LoopWorld& world) {
  const loop::LoopOptions& options = inputs.config.loops;
  const std::vector<int> parts = PartsOf(world);
  loop::FoundConstellations found = loop::FindConstellations(
      {world.map, world.association, inputs.classes, world.odometry, parts}, options);
  if (!found.complete) {
    context.progress().Warn(
        fmt::format("loops.max_seeds: {} starts of constellations were tried and more are left, so "
                    "loops may be missing; raise it, or lower loops.max_spread_m",
                    options.max_seeds));
  }
  std::vector<Constellation>& proposed = found.constellations;
  const std::vector<Constellation> known_again =
      loop::ProposeKnownAgain(visits, world.map, proposed);
  std::vector<Constellation> verified(proposed.size() + known_again.size());
  if (!verified.empty()) {  // most captures propose nothing, and evidence takes all views
    std::set<ObjectId> all;
    for (const MapObject& object : world.map.objects) all.insert(object.id);
    const Result<loop::LoopEvidence> evidence = CollectEvidence(context, inputs, world, all);
    if (!evidence.ok()) return evidence.error();
    ParallelFor(proposed.size(), [&](std::size_t i) {
      verified[i] = loop::VerifyConstellation(proposed[i], world.map, *evidence, options);
    });
    ParallelFor(known_again.size(), [&](std::size_t i) {
      verified[proposed.size() + i] =
          loop::VerifyKnownAgain(known_again[i], world.map, *evidence, options);
    });
  }
  return loop::AcceptLoops(verified, world.map, world.association, options, world.odometry);
}

// Visits of objects that were known again, one object's after the other's.
struct KnownAgain {
  std::vector<ObjectTrack> visits;  // ids are places in the list: views are planned by them
  std::vector<ObjectId> objects;    // of the visits
};

KnownAgain VisitsOfMap(const LoopWorld& world, const loop::LoopOptions& options) {
  KnownAgain known;
  for (const ObjectTrack& track : world.association.tracks) {
    if (std::ranges::find(world.map.objects, track.id, &MapObject::id) == world.map.objects.end())
      continue;
    std::vector<ObjectTrack> own = loop::Visits(track, options);
    if (own.size() < 2) continue;
    for (ObjectTrack& visit : own) {
      visit.id = ObjectId{static_cast<int>(known.visits.size())};
      known.visits.push_back(std::move(visit));
      known.objects.push_back(track.id);
    }
  }
  return known;
}

// Which of the visits stand apart from the one before. What was measured is held for a batch of
// visits and the one before it: a camera that goes round for an hour visits everything many times.
class VisitJudge {
 public:
  VisitJudge(const KnownAgain& known,
             const Eigen::Vector3d& up_world,
             const loop::LoopOptions& options)
      : known_(known), up_world_(up_world), options_(options) {}

  // The next visits.
  void Judge(std::span<const TrackViews> batch) {
    std::vector<loop::ObjectEvidence> measured(1 + batch.size());  // the one before, then these
    measured.front() = std::move(before_);
    ParallelFor(batch.size(), [&](std::size_t n) { Append(batch[n].views, measured[n + 1]); });
    std::vector<char> is_apart(batch.size());
    ParallelFor(batch.size(), [&](std::size_t n) {
      is_apart[n] = Follows(num_judged_ + n) &&
                    loop::StandApart(measured[n], measured[n + 1], up_world_, options_);
    });
    for (const char apart : is_apart) {
      if (Follows(num_judged_)) apart_[known_.objects[num_judged_]].push_back(apart != 0);
      ++num_judged_;
    }
    before_ = std::move(measured.back());
  }
  [[nodiscard]] loop::StandingApart Take() && { return std::move(apart_); }

 private:
  // Of the same object as the visit before.
  [[nodiscard]] bool Follows(std::size_t visit) const {
    return visit > 0 && known_.objects[visit - 1] == known_.objects[visit];
  }

  const KnownAgain& known_;
  const Eigen::Vector3d up_world_;
  const loop::LoopOptions& options_;
  std::size_t num_judged_ = 0;
  loop::ObjectEvidence before_;  // of the last visit
  loop::StandingApart apart_;
};

// The visits of objects that were known again, where they stand apart.
Result<loop::PartedObjects> FindParted(const StageContext& context,
                                       const RunInputs& inputs,
                                       const LoopWorld& world) {
  const loop::LoopOptions& options = inputs.config.loops;
  const KnownAgain known = VisitsOfMap(world, options);
  if (!options.constellations || known.visits.empty()) return loop::PartedObjects();
  VisitJudge judge(known, loop::UpDirection(world.map), options);
  const auto use = [&](std::span<TrackViews> batch) {
    judge.Judge(batch);
    return Ok();
  };
  const Status judged = ForDepthViews(context, inputs, world, known.visits, use);
  if (!judged.ok()) return judged.error();
  return loop::PartVisits(world.association, std::move(judge).Take(), options);
}

// The path is closed by what ties it together so far, where that moves what was seen of an object
// apart. Whether it was.
Result<bool> Close(const StageContext& context,
                   const RunInputs& inputs,
                   const std::set<ObjectId>& just_judged,
                   LoopWorld& world) {
  const graph::GraphOptions& options = inputs.config.optimize;
  if (!options.use_objects) return false;
  Result<mapping::SolvedPath> solved =
      mapping::SolvePath(world.odometry, world.ground, world.edges, options, world.map);
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
  if (Status status = JudgeMovedApart(context, inputs, before, just_judged, world); !status.ok())
    return status.error();
  return true;
}

// One pass of the search along the path as it is, and the path closed by what it finds. Whether it
// found anything or moved anything.
Result<bool> SearchOnce(const StageContext& context,
                        const RunInputs& inputs,
                        LoopWorld& world,
                        Loops& all) {
  Result<Loops> found = DetectLoops(context, inputs, all.visits, world);
  if (!found.ok()) return found.error();
  std::set<ObjectId> just_judged;
  for (const ObjectMerge& merge : found->merges) just_judged.insert(merge.kept);
  if (Status status = JudgeMerged(context, inputs, *found, world); !status.ok())
    return status.error();
  world.edges.insert(world.edges.end(), found->edges.begin(), found->edges.end());
  const bool merged = !found->merges.empty();
  loop::Append(std::move(found).value(), all);
  const Result<bool> moved = Close(context, inputs, just_judged, world);
  if (!moved.ok()) return moved.error();
  return merged || *moved;
}

// Constellations and duplicates, again and again along the path that they close, visits of doubtful
// objects by themselves until nothing more is found among them.
Result<Loops> CloseByObjects(const StageContext& context,
                             const RunInputs& inputs,
                             LoopWorld& world) {
  Loops loops;
  if (!inputs.config.loops.enabled) return loops;
  const Result<loop::PartedObjects> parted = FindParted(context, inputs, world);
  if (!parted.ok()) return parted.error();
  Result<PartedWorld> whole = Part(context, inputs, *parted, world);
  if (!whole.ok()) return whole.error();
  loops.visits = parted->visits;
  bool is_parted = !parted->visits.empty();
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    if (context.progress().StopRequested()) return Interrupted();
    const Result<bool> found = SearchOnce(context, inputs, world, loops);
    if (!found.ok()) return found.error();
    if (*found) continue;
    if (!is_parted) break;
    const loop::RejoinedVisits rejoined = loop::RejoinVisits(loops.visits, loops.merges);
    if (Status status = Rejoin(context, inputs, rejoined.whole, *whole, world); !status.ok())
      return status.error();
    const Loops again{{}, rejoined.merges, {}, {}, {}};
    if (Status status = JudgeMerged(context, inputs, again, world); !status.ok())
      return status.error();
    loop::Append(again, loops);
    is_parted = false;
  }
  return loops;
}

// Objects that stand in a surer one leave the map, and the map says so.
Status DropIntruders(const StageContext& context, const RunInputs& inputs, LoopWorld& world) {
  const loop::LoopOptions& options = inputs.config.loops;
  ObjectMap& map = world.map;
  const std::vector<loop::Intruder> suspects = loop::SuspectIntruders(map, options, PartsOf(world));
  if (suspects.empty()) return Ok();
  std::set<ObjectId> wanted;
  for (const loop::Intruder& suspect : suspects) wanted.insert({suspect.id, suspect.host});
  const Result<loop::LoopEvidence> evidence = CollectEvidence(context, inputs, world, wanted);
  if (!evidence.ok()) return evidence.error();
  const std::vector<loop::Intruder> intruders =
      loop::FindIntruders(suspects, map, *evidence, options);
  std::map<ObjectId, std::string> names;
  for (const MapObject& object : map.objects) names[object.id] = ObjectName(object);
  for (const loop::Intruder& intruder : intruders) {
    map.dropped.push_back(
        fmt::format("{}: stands in {}, which is surer", names[intruder.id], names[intruder.host]));
    std::erase_if(map.objects, [&](const MapObject& object) { return object.id == intruder.id; });
  }
  return Ok();
}

void AddAppearance(const loop::AcceptedAppearance& appearance, Loops& loops) {
  loops.appearance = appearance.loops;
  loops.edges.insert(loops.edges.end(), appearance.edges.begin(), appearance.edges.end());
}

// What was made for objects that are still there.
Proposals MadeForMap(Proposals made, const ObjectMap& map) {
  std::set<ObjectId> there;
  for (const MapObject& object : map.objects) there.insert(object.id);
  std::erase_if(made.candidates,
                [&](const ShapeCandidate& candidate) { return !there.contains(candidate.object); });
  std::set<std::string> models;
  for (const ShapeCandidate& candidate : made.candidates) models.insert(candidate.model);
  std::erase_if(made.models, [&](const auto& model) { return !models.contains(model.first); });
  return made;
}

// Visits that stay objects of their own have copies of their object's candidates, whose models are
// other stages': they become this stage's as well.
Status AddModelsOfCopies(const StageContext& context, Proposals& made) {
  for (const ShapeCandidate& candidate : made.candidates) {
    if (made.models.contains(candidate.model)) continue;
    Result<VoxelGrid> grid = ReadModel(context, StageOfModel(candidate.source), candidate.model);
    if (!grid.ok()) return grid.error();
    made.models.emplace(candidate.model, std::move(grid).value());
  }
  return Ok();
}

Status Write(StageContext& context, const LoopWorld& world, const Loops& loops) {
  Proposals made = MadeForMap(world.made, world.map);
  if (Status status = AddModelsOfCopies(context, made); !status.ok()) return status;
  const Status written = WriteFiles(
      context,
      {{"loops.json", [&] { return artifact::EncodeLoops(loops, "loops.json"); }},
       {"objects.json", [&] { return artifact::EncodeObjectMap(world.map, "objects.json"); }},
       {"candidates.json", [&] { return artifact::EncodeProposals(made, "candidates.json"); }},
       {"registrations.json",
        [&] {
          return artifact::EncodeRegistrations(PlacedRegistrations(world), "registrations.json");
        }},
       {"tracks.json",
        [&] { return artifact::EncodeAssociation(world.association, "tracks.json"); }}});
  if (!written.ok()) return written;
  if (Status status = WriteModels(context, made.models); !status.ok()) return status;
  return CopyChosenModels(context, world.map, made.models);
}

StageSummary Summary(const Loops& loops, int num_measured_again, std::size_t num_objects) {
  const auto accepted = std::ranges::count_if(loops.constellations, &Constellation::accepted);
  const auto seen_again = std::ranges::count_if(loops.appearance, &AppearanceLoop::accepted);
  return StageSummary{
      fmt::format("{} of {} constellations and {} of {} loops by appearance accepted, {} "
                  "neighbours measured again, {} objects merged, {} edges; {} objects",
                  accepted,
                  loops.constellations.size(),
                  seen_again,
                  loops.appearance.size(),
                  num_measured_again,
                  loops.merges.size(),
                  loops.edges.size(),
                  num_objects),
      {{"num_accepted", static_cast<double>(accepted)},
       {"num_appearance", static_cast<double>(seen_again)},
       {"num_measured_again", static_cast<double>(num_measured_again)},
       {"num_merges", static_cast<double>(loops.merges.size())},
       {"num_edges", static_cast<double>(loops.edges.size())},
       {"num_objects", static_cast<double>(num_objects)}}};
}

}  // namespace

Result<StageSummary> RunLoops(StageContext& context, const RunInputs& inputs) {
  mapping::ClosedTrajectory by_appearance;
  Result<LoopWorld> read = ReadWorld(context, inputs, by_appearance);
  if (!read.ok()) return read.error();
  LoopWorld& world = *read;
  Result<Loops> found = CloseByObjects(context, inputs, world);
  if (!found.ok()) return found.error();
  Loops& loops = *found;
  AddAppearance(by_appearance.appearance, loops);
  if (context.progress().StopRequested()) return Interrupted();
  if (Status status = DropIntruders(context, inputs, world); !status.ok()) return status.error();
  MoveObjects(world.odometry, world.tracked, world.map);
  if (Status status = Write(context, world, loops); !status.ok()) return status.error();
  return Summary(loops, by_appearance.num_reregistered, world.map.objects.size());
}

}  // namespace deepslam::stages
