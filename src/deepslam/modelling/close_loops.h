// Loops closed by objects: constellations seen again, duplicates, and what the path that they close
// makes of the objects.
#pragma once

#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/loop/appearance.h"
#include "deepslam/modelling/loop_world.h"
#include "deepslam/scene/loop.h"

namespace deepslam::modelling {

// The map before, and the path that appearance has closed already.
struct MapWithLoops {
  Trajectory tracked;  // in which the map lies
  Odometry odometry;   // closed by appearance
  Ground ground;       // likewise
  loop::AcceptedAppearance appearance;
  Association association;
  Proposals proposals;  // of the stages before, without models
  ObjectMap map;
};

struct ClosedMap {
  ObjectMap map;            // in the world of the tracked path
  Association association;  // merged tracks
  Proposals made;           // candidates of the map's objects added here, with models
  std::vector<CandidateRegistration> registrations;  // of all candidates of objects scored anew
  Loops loops;                                       // of both kinds
};

// Searches again and again along the path that is closed so far, until nothing more is found; then
// drops duplicate landmarks, objects that stand in a surer one. Errors: a missing model, those of
// the graph, Interrupted.
[[nodiscard]] Result<ClosedMap> CloseLoops(MapWithLoops before, const LoopClosing& closing);

}  // namespace deepslam::modelling
