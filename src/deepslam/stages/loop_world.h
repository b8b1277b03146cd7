// What stage `loops` works on: cameras, ground and objects where the loops that are closed so far
// put them; and objects judged anew there, because they are one from now on, because the loops
// moved their views apart, or because their visits are looked at one by one.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/loop/visits.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

struct LoopWorld {
  std::shared_ptr<const ShelvedSegments> segments;
  Trajectory tracked;
  Odometry odometry;  // as closed so far
  Ground ground;
  std::vector<RelativePose> edges;  // of loops of both kinds, and of neighbours measured again
  Association association;
  Proposals proposals;  // of the stages before
  Proposals made;       // here, with models
  ObjectMap map;
  // Of all candidates of the objects judged anew, in the world as it was then.
  std::map<ObjectId, std::vector<CandidateRegistration>> registrations;
  std::map<ObjectId, int> num_judged;
};

// How what the object's best view saw moves from one path to another; without views: not at all.
[[nodiscard]] Pose3 MovedWith(const Trajectory& before,
                              const Trajectory& after,
                              const MapObject& object);

// The largest distance by which that moves what a view saw of the object against what its best view
// saw: views of both ends of a stretch that is corrected. `centre` is the object's in the world of
// `before`.
[[nodiscard]] double MovedApart_m(const Trajectory& before,
                                  const Trajectory& after,
                                  const MapObject& object,
                                  const Eigen::Vector3d& centre);

void MoveObjects(const Trajectory& before, const Trajectory& after, ObjectMap& map);

// Of all candidates of the objects judged anew, in the order of the map, moved with their object so
// that the chosen one stands where it stands now.
[[nodiscard]] std::vector<CandidateRegistration> PlacedRegistrations(const LoopWorld& world);

// Depth views of these tracks, a few tracks at a time.
[[nodiscard]] Status ForDepthViews(const pipeline::StageContext& context,
                                   const RunInputs& inputs,
                                   const LoopWorld& world,
                                   std::span<const ObjectTrack> tracks,
                                   const std::function<Status(std::span<TrackViews>)>& use);

[[nodiscard]] Result<VoxelGrid> ReadChosenModel(const pipeline::StageContext& context,
                                                const LoopWorld& world,
                                                const MapObject& object);

// Objects that are one from now on are registered and selected with everything that was seen of
// them, views moved by the corrections of the constellations that say so.
[[nodiscard]] Status JudgeMerged(const pipeline::StageContext& context,
                                 const RunInputs& inputs,
                                 const Loops& found,
                                 LoopWorld& world);

// Objects whose views the closed path has moved apart since `before`, but for those that were just
// judged.
[[nodiscard]] Status JudgeMovedApart(const pipeline::StageContext& context,
                                     const RunInputs& inputs,
                                     const Trajectory& before,
                                     const std::set<ObjectId>& just_judged,
                                     LoopWorld& world);

// Objects as they were before their visits were parted, by id.
struct PartedWorld {
  Trajectory trajectory;  // at that time
  std::vector<PartedVisit> visits;
  std::map<ObjectId, MapObject> objects;
  std::map<ObjectId, ObjectTrack> tracks;
};

// The visits take the places of their objects, each judged by what it saw alone.
[[nodiscard]] Result<PartedWorld> Part(const pipeline::StageContext& context,
                                       const RunInputs& inputs,
                                       const loop::PartedObjects& parted,
                                       LoopWorld& world);

// These objects are whole again, and judged anew where the path has moved their views apart since.
[[nodiscard]] Status Rejoin(const pipeline::StageContext& context,
                            const RunInputs& inputs,
                            const std::set<ObjectId>& whole,
                            const PartedWorld& parted,
                            LoopWorld& world);

}  // namespace deepslam::stages
