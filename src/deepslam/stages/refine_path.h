// The part of stage `track` behind tracking itself: keyframes that see the same are measured
// against each other (loop/covisible.h), and the path is what all measurements agree on.
#pragma once

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/stages/keyframe_pyramids.h"
#include "deepslam/stages/plan.h"

namespace deepslam::stages {

// For the keyframes of the capture: to be given those that tracking has read, then to RefinePath.
[[nodiscard]] KeyframePyramids PyramidsToRefine(const RunInputs& inputs);

// Adds the edges that are borne out to the odometry's, moves its poses to where the graph of
// cameras has them, and returns how many edges these are. Keyframes that cannot be read take no
// part, with a warning. Beside the edges and poses themselves memory does not depend on the length
// of the capture. After an error the odometry is unfinished.
[[nodiscard]] Result<int> RefinePath(const RunInputs& inputs,
                                     KeyframePyramids pyramids,
                                     Progress& progress,
                                     Odometry& odometry);

}  // namespace deepslam::stages
