// Which sub-trajectories of a trajectory have a measured place relative to each other.
//
// Where tracking finds nothing in common with the frames before (two captures in one, a teleport),
// it starts anew at the last pose: the keyframe there is lost, and the edge that joins it is
// composed. Such a join says nothing about where both sides lie; an edge that was measured between
// them (tracking met an earlier keyframe again, a loop, neighbours re-registered) does.
#pragma once

#include <span>
#include <vector>

#include "deepslam/scene/trajectory.h"

namespace deepslam {

// Keyframes [first_keyframe, end_keyframe), positions in the list of keyframes, that follow each
// other in one part.
struct MeasuredSubTrajectory {
  int part = 0;  // 0 first seen, then 1, ...; one may come back behind another
  int first_keyframe = 0;
  int end_keyframe = 0;
};

// What an edge says of parts. The measurements themselves take thirty times as much memory.
struct KeyframeJoin {
  FrameIdx i;
  FrameIdx j;
  bool composed = false;
};
// In the order of the edges: those of tracking, and whatever was measured later.
[[nodiscard]] std::vector<KeyframeJoin> JoinsOf(const Odometry& odometry,
                                                std::span<const RelativePose> later = {});

// Ascending; together they hold every keyframe. One sub-trajectory where everything was measured.
// Joins of frames that are no keyframes say nothing.
[[nodiscard]] std::vector<MeasuredSubTrajectory> MeasuredSubTrajectories(
    std::span<const TrackedFrame> frames,
    std::span<const FrameIdx> keyframes,
    std::span<const KeyframeJoin> joins);

// The part of each frame. A sub-trajectory reaches from its first keyframe to before the next
// one's; what comes before all keyframes is the first sub-trajectory's. All 0 without keyframes.
[[nodiscard]] std::vector<int> PartsOfFrames(const Trajectory& trajectory,
                                             std::span<const KeyframeJoin> joins);

}  // namespace deepslam
