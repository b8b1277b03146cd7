// Camera tracking over a whole capture: every frame gets a pose and an honest status, keyframes get
// relative-pose edges.
//
// Tracking world: camera of the first usable frame = identity. Each frame is aligned to the current
// keyframe
// (`reference` "keyframe") or to the frame before it (the paper's plain behaviour). A frame that
// cannot be aligned is tried against the frame before it and the last keyframes; if that fails it
// is kLost, carries the last pose, and what follows is joined by an edge of low information until
// an earlier keyframe is seen again. Frames of one depth at every pixel are no measurement: kLost,
// or kDegenerate where the capture has no others. With keyframes as
// reference, what has moved since earlier ones is not aligned to (moved_surfaces.h). Times may jump
// back; all goes on as if one more interval had passed. Frames are streamed; memory does not depend
// on the length of the capture. Same result for any thread count.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/core/options.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/frame_source.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::tracking {

struct OdometryOptions {
  alignment::AlignmentOptions alignment;
  std::string reference = "keyframe";  // "keyframe" or "previous": what a frame is aligned to
  bool motion_prediction = true;       // constant velocity as one of the starts
  bool rotation_search = true;  // image-based rotation as one of the starts: survives fast turns
  bool wide_search = true;      // more starts (turns about the scene) for a doubtful alignment
  bool skip_edges = true;  // also join each keyframe to the one before the last, where they overlap
  double keyframe_distance_m = 0.10;      // a new keyframe beyond this distance ...
  double keyframe_angle_deg = 8;          // ... or this angle from the current one ...
  double keyframe_min_overlap = 0.65;     // ... or below this overlap with it
  int num_relocalisation_keyframes = 12;  // last keyframes kept to find the way back after a loss
  double min_valid_share = 0.03;          // a frame with less usable depth is not aligned
  // Standard deviations behind the edges that carry a lost frame, and those of poses that came with
  // the capture.
  double lost_translation_m = 0.5;
  double lost_rotation_deg = 30;
  double capture_translation_m = 0.01;
  double capture_rotation_deg = 0.5;
};

void Describe(OptionsVisitor& visitor, OdometryOptions& options);

// A keyframe as it was read, for who looks at it next: nothing is hidden from its pyramid.
struct ReadKeyframe {
  FrameIdx frame;
  std::shared_ptr<const alignment::FramePyramid> pyramid;
  DepthImage depth_m;
};

// Stage `track`. `take` is given keyframes as they are found, in their order and one at a time:
// most of them, and some that are given up later. InvalidInput when no frame, or less than half of
// them, could be read, or none has usable depth.
[[nodiscard]] Result<Odometry> EstimateOdometry(const FrameSource& frames,
                                                const OdometryOptions& options,
                                                Progress& progress,
                                                const std::function<void(ReadKeyframe)>& take = {});

// The poses that came with the capture, in the tracking world (--poses capture). Frames without one
// are interpolated between their neighbours (kLost); keyframes by the same rule of distance and
// angle, edges from relative poses with the information of capture_translation_m and
// capture_rotation_deg. InvalidInput naming groundtruth.txt when the capture has no poses.
[[nodiscard]] Result<Odometry> OdometryFromCapturePoses(const FrameSource& frames,
                                                        const OdometryOptions& options,
                                                        Progress& progress);

}  // namespace deepslam::tracking
