// The part of stage `track` behind tracking itself: keyframes that see the same are measured
// against each other (loop/covisible.h), and the path is what all measurements agree on.
#pragma once

#include "deepslam/core/result.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/stages/keyframe_pyramids.h"
#include "deepslam/stages/plan.h"

namespace deepslam::stages {

// For the keyframes of the capture: to be given those that tracking has read, then to RefinePath.
[[nodiscard]] KeyframePyramids PyramidsToRefine(const RunInputs& inputs);

// Adds the edges that are borne out behind the odometry's, in scratch files of the stage, and moves
// its poses to where the graph of cameras has them. Keyframes that cannot be read take no part,
// with a warning. Beside the poses memory does not depend on the length of the capture. After an
// error the odometry is unfinished.
[[nodiscard]] Status RefinePath(const pipeline::StageContext& context,
                                const RunInputs& inputs,
                                KeyframePyramids pyramids,
                                Odometry& odometry);

}  // namespace deepslam::stages
