// From a detector's raw boxes to detections of the map's classes.
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/detect/detector.h"
#include "deepslam/frames/frame.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::detect {

struct DetectOptions {
  double min_score = 0.3;  // detections below are dropped
  double duplicate_iou =
      0.7;  // of two boxes of different classes with more overlap the better stays
  double same_class_iou = 0.6;  // the same for two labels that mean one class of the table
  double min_side_px = 12;      // boxes narrower or lower are too small to say anything
};
void Describe(OptionsVisitor& visitor, DetectOptions& options);

// Detections of one frame, best score first. Ids are left invalid: the caller numbers them over the
// capture. Labels that no class of the table knows are dropped. An error is the detector's.
[[nodiscard]] Result<std::vector<Detection>> DetectFrame(const Detector& detector,
                                                         const Frame& frame,
                                                         const ClassTable& classes,
                                                         const DetectOptions& options);

// The same from raw detections: score, class mapping, duplicates. `frame` gives index and image
// size.
[[nodiscard]] std::vector<Detection> MapDetections(std::span<const RawDetection> raw,
                                                   const Frame& frame,
                                                   const ClassTable& classes,
                                                   const DetectOptions& options);

}  // namespace deepslam::detect
