// Behind tracking: sub-trajectories that tracking could not tie together (scene/measured_parts.h)
// are joined where they show one place, so that everything that is made of the path (ground, rooms,
// objects) is made of all of it.
#pragma once

#include "deepslam/core/options.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/mapping/close_by_appearance.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::mapping {

struct JoiningOptions {
  bool enabled = true;
};
void Describe(OptionsVisitor& visitor, JoiningOptions& options);

// How many sub-trajectories nothing ties together; 0 without keyframes.
[[nodiscard]] int CountSubTrajectories(const Odometry& odometry);

// The path closed by appearance (close_by_appearance.h), and behind its edges those that measure
// one sub-trajectory against another. As it was where it is one, where no place is seen from two of
// them, and with a warning where the graph cannot be solved. Tracking world; the first keyframe
// stays. Errors: Interrupted.
[[nodiscard]] Result<Odometry> JoinSubTrajectories(const FrameSource& frames,
                                                   Odometry odometry,
                                                   const AppearanceClosing& options,
                                                   Progress& progress);

}  // namespace deepslam::mapping
