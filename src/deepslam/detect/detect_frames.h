// Detections of a capture's frames: what a detector sees in their colour, what the user gave, and
// clusters of depth on the ground that neither explains. All look at pictures turned upright.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/detect/cluster_detector.h"
#include "deepslam/detect/detect_frame.h"
#include "deepslam/detect/detector.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::detect {

// What frames are looked at with. All outlive the call.
struct DetectionInputs {
  const FrameSource& frames;
  const Trajectory& trajectory;
  const Ground& ground;
  const ClassTable& classes;
  std::span<const Detection> given;  // by the user; ascending frames, boxes and masks of the frame
};

struct DetectFramesOptions {
  DetectOptions detect;
  ClusterOptions clusters;
};

// Loads the detector for pictures of these sides (without pixels: of several). Called once, beside
// the search for clusters.
using DetectorLoader = std::function<Result<std::shared_ptr<const Detector>>(Sides pictures)>;

struct FrameDetections {
  FrameIdx frame;
  // The detector's, those given, then clusters; ids invalid. None where colour or depth could not
  // be read.
  std::vector<Detection> detections;
  // The detector saw a person: such frames are shown nowhere. Nothing when none looked.
  std::optional<bool> contains_person = {};
};

// Keyframes, or all frames, and those that `given` speaks of; ascending. None of which the pose is
// unknown: their detections could match anything.
[[nodiscard]] std::vector<FrameIdx> FramesToSearch(const Trajectory& trajectory,
                                                   std::span<const Detection> given,
                                                   bool all);

// Of the wanted frames (ascending), those that show surface that the ones before did not
// (new_surface.h), that `given` speaks of, whose depth cannot be read or whose place in the first
// keyframe's world is unknown. Beside one that is blurred the sharpest within 0.15 s is looked at
// as well, unless `given` speaks of it or its world is another. Where no ground is known all that
// are wanted, and no others: objects are found by votes of frames then, which need many. Errors:
// Interrupted.
[[nodiscard]] Result<std::vector<FrameIdx>> FramesOfNewSurface(const DetectionInputs& inputs,
                                                               std::span<const FrameIdx> wanted,
                                                               Progress& progress);

// One for each of `wanted`, in their order, the same for any thread count. Without `load` no
// detector looks. A frame that cannot be read, or that the detector fails on, is told by a warning.
// Errors: the loader's, and Interrupted.
[[nodiscard]] Result<std::vector<FrameDetections>> DetectFrames(const DetectionInputs& inputs,
                                                                std::span<const FrameIdx> wanted,
                                                                const DetectorLoader& load,
                                                                const DetectFramesOptions& options,
                                                                Progress& progress);

}  // namespace deepslam::detect
