// Silhouettes of all detections of a capture, frame by frame.
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/segment/segment_objects.h"

namespace deepslam::segment {

// All outlive the call.
struct SegmentationInputs {
  const FrameSource& frames;
  const Trajectory& trajectory;
  const Ground& ground;
  const ClassTable& classes;
  std::span<const Detection> detections;  // those of a frame one after another
};

// What SegmentFrame says of each detection, in their order; nothing of those of frames that cannot
// be read. A few frames are held at a time; the same for any thread count. Errors: Interrupted
// only.
[[nodiscard]] Result<std::vector<Segment>> SegmentFrames(const SegmentationInputs& inputs,
                                                         const SegmentOptions& options,
                                                         Progress& progress);

}  // namespace deepslam::segment
