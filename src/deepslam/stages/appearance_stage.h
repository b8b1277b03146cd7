// The part of stage `loops` that looks at keyframes: loops by appearance, neighbours measured
// again, and the trajectory that they make.
#pragma once

#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/loop/appearance.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/stages/plan.h"

namespace deepslam::stages {

// Cameras and ground as tracked, or as the graph has them with the loops' edges; in the tracking
// world either way (the first keyframe stays).
struct ClosedTrajectory {
  std::vector<TrackedFrame> frames;
  Ground ground;
  loop::AcceptedAppearance appearance;  // edges: those of neighbours behind those of loops
  int num_measured_again = 0;           // edges of neighbours
};

// Keyframes that cannot be read take no part, with a warning.
[[nodiscard]] Result<ClosedTrajectory> CloseByAppearance(const pipeline::StageContext& context,
                                                         const RunInputs& inputs,
                                                         const Odometry& odometry,
                                                         const Ground& ground);

}  // namespace deepslam::stages
