// A sub-trajectory that began behind a loss, found at a keyframe of an earlier one.
#pragma once

#include <optional>

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/tracking/monotonic_clock.h"
#include "deepslam/tracking/placement.h"
#include "deepslam/tracking/sub_trajectories.h"

namespace deepslam::tracking {

struct Rejoining {
  PosedFrame keyframe;                  // of the earlier sub-trajectory
  alignment::FrameAlignment alignment;  // of the frame to it
  Pose3 motion;                         // of the frame's sub-trajectory, in the world
  // The sub-trajectory followed what had moved: frames of it before this one are lost.
  bool gives_up = false;
};

// Of the sub-trajectory that `frame`, its next keyframe, belongs to. It joins the oldest keyframe
// that the frame surely fits and whose free space its keyframes do not violate. Those that
// do give way, where the sub-trajectory is as short as somebody takes to pass by.
[[nodiscard]] std::optional<Rejoining> FindRejoining(const PathSoFar& path,
                                                     const PosedFrame& frame,
                                                     const SubTrajectories& sub_trajectories,
                                                     const MonotonicClock& clock);

// Whether the frame's sub-trajectory is as short as somebody takes who comes so near that little
// else is in view, and shorter than the earlier one was before it. Not where keyframes of others
// came in between.
[[nodiscard]] bool IsPassingBy(const PosedFrame& frame,
                               int earlier,
                               const KeyframeWindow& keyframes,
                               const SubTrajectories& sub_trajectories,
                               const MonotonicClock& clock);

}  // namespace deepslam::tracking
