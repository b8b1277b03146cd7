#include "deepslam/detect/turned_detections.h"

#include "deepslam/geometry/upright.h"

namespace deepslam::detect {

Result<std::vector<RawDetection>> DetectTurned(const Detector& detector,
                                               const ColourImage& image,
                                               QuarterTurn upright) {
  if (upright == QuarterTurn::kNone) return detector.Detect(image);
  const ColourImage turned = Turned(image, upright);
  Result<std::vector<RawDetection>> found = detector.Detect(turned);
  if (!found.ok()) return found;
  const QuarterTurn back = Inverse(upright);
  for (RawDetection& detection : *found) {
    detection.box_px = Turned(detection.box_px, turned.width(), turned.height(), back);
    if (!detection.mask.empty()) detection.mask = Turned(detection.mask, back);
  }
  return found;
}

}  // namespace deepslam::detect
