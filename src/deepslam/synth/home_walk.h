// The way of somebody who films a home: through every door, round every room.
#pragma once

#include <vector>

#include "deepslam/synth/home_plan.h"
#include "deepslam/synth/scene_description.h"

namespace deepslam::synth {

// Sets the scene's walk and the number of its frames: from room to room as the doors lead, and in
// each from corner to corner, looking across it, round what stands there (`taken`). Rooms that
// nobody can walk into are looked at from their door, or not at all.
void AddWalk(const HomePlan& plan,
             const std::vector<FloorRectangle>& taken,
             SceneDescription& scene);

}  // namespace deepslam::synth
