// Which frames of a path are fused: those that see something that the last one did not.
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::fuse {

struct FrameChoice {
  double move_m = 0.05;  // a frame is fused when the camera moved this far since the last one
  double turn_deg = 3;   // or turned this far
  int frame_step = 15;   // or at the latest after so many frames
};

// Of the aligned frames, in order: those that moved, turned or waited enough since the one chosen
// before; of keyframes, which other stages have decoded, half the motion is asked. A recording of
// 30 frames a second shows each point tens of times within a hand's breadth: more of the same costs
// time and says little.
[[nodiscard]] std::vector<FrameIdx> FramesToFuse(std::span<const TrackedFrame> frames,
                                                 const FrameChoice& options);

}  // namespace deepslam::fuse
