#include "deepslam/tracking/keyframe_policy.h"

#include "deepslam/core/angles.h"

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;

// Holes in both depth images leave few common points between frames that see the same place: only
// this share of the asked overlap makes a keyframe of such a frame.
constexpr double kFewCommonPoints = 0.5;
// A camera whose motion nothing shows may be anywhere after a while, also where it would see
// something again: it is compared with what it saw lately.
constexpr double kLongUnobserved_s = 0.5;

}  // namespace

bool IsFarFrom(const Pose3& world_from_keyframe,
               const Pose3& world_from_camera,
               const OdometryOptions& options) {
  const Pose3 moved = world_from_keyframe.Inverse() * world_from_camera;
  return moved.translation_m.norm() > options.keyframe_distance_m ||
         RotationAngle(moved.rotation) > options.keyframe_angle_deg * kRadPerDeg;
}

bool WantsKeyframe(const PosedFrame& keyframe,
                   const PosedFrame& frame,
                   const FrameAlignment* to_keyframe,
                   const OdometryOptions& options) {
  if (to_keyframe != nullptr && to_keyframe->remapped &&
      frame.clock_s - keyframe.clock_s > kLongUnobserved_s)
    return true;
  if (IsFarFrom(keyframe.world_from_camera, frame.world_from_camera, options)) return true;
  return to_keyframe != nullptr &&
         (to_keyframe->inside_ratio < options.keyframe_min_overlap ||
          to_keyframe->overlap_ratio < kFewCommonPoints * options.keyframe_min_overlap);
}

}  // namespace deepslam::tracking
