#include "deepslam/fuse/choose_frames.h"

#include "deepslam/core/angles.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::fuse {
namespace {

bool IsNew(const TrackedFrame& frame, const TrackedFrame& last, const FrameChoice& options) {
  if (frame.frame.value - last.frame.value >= options.frame_step) return true;
  const Pose3 moved = last.world_from_camera.Inverse() * frame.world_from_camera;
  const double share = frame.keyframe == frame.frame ? 0.5 : 1.0;
  return moved.translation_m.norm() >= share * options.move_m ||
         RotationAngle(moved.rotation) >= share * options.turn_deg * kRadPerDeg;
}

}  // namespace

std::vector<FrameIdx> FramesToFuse(std::span<const TrackedFrame> frames,
                                   const FrameChoice& options) {
  std::vector<FrameIdx> chosen;
  const TrackedFrame* last = nullptr;
  for (const TrackedFrame& frame : frames) {
    if (!IsAligned(frame) || (last != nullptr && !IsNew(frame, *last, options))) continue;
    chosen.push_back(frame.frame);
    last = &frame;
  }
  return chosen;
}

}  // namespace deepslam::fuse
