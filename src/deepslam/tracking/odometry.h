// Camera tracking over a whole capture: every frame gets a pose and an honest status, keyframes get
// relative-pose edges.
//
// Tracking world: camera of the first usable frame = identity. Each frame is aligned to the current
// keyframe (`reference` "keyframe") or to the frame before it (the paper's plain behaviour). A
// frame that cannot be aligned is tried against the frame before it and the last keyframes; if that
// fails it is kLost, carries the last pose, and what follows is joined by an edge of low
// information until an earlier keyframe is seen again. Frames of one depth at every pixel are no
// measurement: kLost, or kDegenerate where the capture has no others. With keyframes as reference,
// what has moved since earlier ones is not aligned to (dynamic_mask.h). Times may jump back; all
// goes on as if one more interval had passed (monotonic_clock.h). Frames are streamed; memory does
// not depend on the length of the capture. Same result for any thread count.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/tracking/feature_starts.h"
#include "deepslam/tracking/odometry_options.h"

namespace deepslam::tracking {

// A keyframe as it was read, for who looks at it next: nothing is hidden from its pyramid.
struct ReadKeyframe {
  FrameIdx frame;
  std::shared_ptr<const alignment::FramePyramid> pyramid;
  DepthImage depth_m;
};

// The poses that came with the capture, where tracking starts from and goes on by where it is lost
// (--poses prior): world from camera, in a world of their own; nothing of frames that have none.
using RecordedPoses = std::function<std::optional<Pose3>(FrameIdx)>;

// Where frames may be beside what tracking itself expects; each may be empty.
struct OtherPlaces {
  RecordedPoses recorded;
  FeatureStarts features;
};

// Stage `track`. `take` is given keyframes as they are found, in their order and one at a time:
// most of them, and some that are given up later. InvalidInput when no frame, or less than half of
// them, could be read, or none has usable depth.
[[nodiscard]] Result<Odometry> EstimateOdometry(const FrameSource& frames,
                                                const OdometryOptions& options,
                                                Progress& progress,
                                                const std::function<void(ReadKeyframe)>& take = {},
                                                const OtherPlaces& others = {});

// Those of a capture that are usable: finite, a rotation.
[[nodiscard]] RecordedPoses RecordedPosesOf(const FrameSource& frames);

// The poses that came with the capture, in the tracking world (--poses capture). Frames without one
// are interpolated between their neighbours (kLost); keyframes by the same rule of distance and
// angle, edges from relative poses with the information of capture_translation_m and
// capture_rotation_deg. InvalidInput naming groundtruth.txt when the capture has no poses.
[[nodiscard]] Result<Odometry> OdometryFromCapturePoses(const FrameSource& frames,
                                                        const OdometryOptions& options,
                                                        Progress& progress);

}  // namespace deepslam::tracking
