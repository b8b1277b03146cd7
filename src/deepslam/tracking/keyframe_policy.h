// When a frame becomes a keyframe.
#pragma once

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/tracking/odometry_options.h"
#include "deepslam/tracking/posed_frame.h"

namespace deepslam::tracking {

// Beyond keyframe_distance_m or keyframe_angle_deg.
[[nodiscard]] bool IsFarFrom(const Pose3& world_from_keyframe,
                             const Pose3& world_from_camera,
                             const OdometryOptions& options);

// Whether a placed frame, aligned to `keyframe`, the last one, or to another frame (null), becomes
// the next one: it is far from that, sees too little of what that sees, or has not been shown the
// camera's motion for so long that it is to be compared with what was seen lately.
[[nodiscard]] bool WantsKeyframe(const PosedFrame& keyframe,
                                 const PosedFrame& frame,
                                 const alignment::FrameAlignment* to_keyframe,
                                 const OdometryOptions& options);

}  // namespace deepslam::tracking
