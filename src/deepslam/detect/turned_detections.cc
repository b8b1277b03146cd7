#include "deepslam/detect/turned_detections.h"

#include <utility>

#include "deepslam/geometry/upright.h"

namespace deepslam::detect {
namespace {

// Of a picture of this width and height.
Detection Turned(Detection detection, int width, int height, QuarterTurn turn) {
  detection.box_px = Turned(detection.box_px, width, height, turn);
  if (!detection.mask.empty()) detection.mask = Turned(detection.mask.Unpacked(), turn);
  return detection;
}

}  // namespace

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

std::vector<Detection> DetectClustersTurned(const Frame& frame,
                                            const PinholeCamera& camera,
                                            const Plane& ground_camera,
                                            std::span<const Detection> covered,
                                            const ClassTable& classes,
                                            const ClusterOptions& options,
                                            QuarterTurn upright) {
  if (upright == QuarterTurn::kNone)
    return DetectClusters(frame, camera, ground_camera, covered, classes, options);
  const DepthImage& depth_m = frame.depth_m;
  const Frame turned{frame.idx, frame.time_s, {}, Turned(depth_m, upright)};
  std::vector<Detection> turned_covered;
  for (const Detection& detection : covered)
    turned_covered.push_back(Turned(detection, depth_m.width(), depth_m.height(), upright));
  std::vector<Detection> found = DetectClusters(turned,
                                                Turned(camera, upright),
                                                Turned(ground_camera, upright),
                                                turned_covered,
                                                classes,
                                                options);
  for (Detection& detection : found) {
    detection = Turned(
        std::move(detection), turned.depth_m.width(), turned.depth_m.height(), Inverse(upright));
  }
  return found;
}

}  // namespace deepslam::detect
