// From a detector's raw boxes to detections of the map's classes.
#pragma once

#include <span>
#include <string>
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
  // Of two boxes of different classes with more overlap the better stays: the detector gives one
  // thing two names.
  static constexpr double kDuplicateIou = 0.7;
  // The same for two labels that mean one class of the table, as the detector's own suppression
  // has it (detector.h).
  static constexpr double kSameClassIou = 0.6;
  // Boxes narrower or lower are too small to say anything: at 5 m this is 10 cm.
  static constexpr double kMinSide_px = 12;
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

// Classes that have labels of which a detector knows none, so that it never finds them. A class
// that `delivered` has with the same labels is none of these: that table is made for several
// detectors.
[[nodiscard]] std::vector<const ObjectClass*> NeverDetected(
    const ClassTable& classes,
    const ClassTable& delivered,
    std::span<const std::string> detector_labels);

}  // namespace deepslam::detect
