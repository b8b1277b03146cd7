// When a frame becomes a keyframe, and what it is joined to beside the keyframe before.
#pragma once

#include <optional>

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/tracking/keyframe_window.h"
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

// A pose that was measured twice: the information that either measurement has beside the other,
// and the pose that both make likely (least squares).
struct JointMeasurement {
  Matrix6d information_a;
  Matrix6d information_b;
  Pose3 world_from_camera;
};

struct MeasuredPose {
  Pose3 world_from_camera;
  Matrix6d information;  // of t2v(measured^-1 * true)
};

// Two measurements that disagree beyond their covariances are both less certain than they say: the
// Birge ratio scales them down.
[[nodiscard]] JointMeasurement Joined(const MeasuredPose& a, const MeasuredPose& b);

// An edge to the keyframe before the last.
struct SkipEdge {
  alignment::FrameAlignment to_before_last;
  JointMeasurement joint;  // a: by the last keyframe, b: by the one before
};

// `to_last`: the ok alignment of the next keyframe to the last one. Nothing where skip edges are
// not asked for, there is no other keyframe of its sub-trajectory, or the two do not overlap or fit
// well enough.
[[nodiscard]] std::optional<SkipEdge> MeasureSkipEdge(const KeyframeWindow& keyframes,
                                                      const PosedFrame& next,
                                                      const alignment::FrameAlignment& to_last,
                                                      const OdometryOptions& options);

}  // namespace deepslam::tracking
