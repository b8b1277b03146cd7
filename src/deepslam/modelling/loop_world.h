// What loops are closed in: cameras, ground and objects where the loops that are closed so far put
// them.
#pragma once

#include <map>
#include <vector>

#include "deepslam/graph/object_graph.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/modelling/object_options.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::modelling {

struct LoopWorld {
  Trajectory tracked;
  Odometry odometry;  // as closed so far
  Ground ground;
  std::vector<RelativePose> edges;  // of loops of both kinds, and of re-registered keyframes
  Association association;
  Proposals proposals;  // of the stages before, without models
  Proposals made;       // here, with models
  ObjectMap map;
  // Of all candidates of the objects scored anew, in the world as it was then.
  std::map<ObjectId, std::vector<CandidateRegistration>> registrations;
  std::map<ObjectId, int> num_rescored;
};

// What closing loops is done with.
struct LoopClosing {
  const ObjectSources& sources;
  const ClassTable& classes;
  const ObjectOptions& objects;
  const loop::LoopOptions& loops;
  const graph::GraphOptions& graph;  // of the path that objects close
};

[[nodiscard]] MapObject* FindObject(ObjectMap& map, ObjectId id);
[[nodiscard]] ObjectTrack* FindTrack(Association& association, ObjectId id);
void EraseTrack(Association& association, ObjectId id);

// The part of the path that each frame is in (scene/measured_parts.h), with what loops have
// measured so far.
[[nodiscard]] std::vector<int> PartsOf(const LoopWorld& world);

// Of all candidates of the objects scored anew, in the order of the map, moved with their object so
// that the chosen one stands where it stands now.
[[nodiscard]] std::vector<CandidateRegistration> PlacedRegistrations(const LoopWorld& world);

}  // namespace deepslam::modelling
