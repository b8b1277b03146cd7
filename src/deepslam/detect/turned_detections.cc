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

UprightClusters FindClustersTurned(const Frame& frame,
                                   const PinholeCamera& camera,
                                   const Plane& ground_camera,
                                   const ClassTable& classes,
                                   const ClusterOptions& options,
                                   QuarterTurn upright) {
  const DepthImage& depth_m = frame.depth_m;
  UprightClusters clusters{upright, depth_m.width(), depth_m.height(), {}};
  if (upright == QuarterTurn::kNone) {
    clusters.found = FindClusters(frame, camera, ground_camera, classes, options);
    return clusters;
  }
  const Frame turned{frame.idx, frame.time_s, {}, Turned(depth_m, upright)};
  clusters.found = FindClusters(
      turned, Turned(camera, upright), Turned(ground_camera, upright), classes, options);
  return clusters;
}

std::vector<Detection> UncoveredTurned(UprightClusters clusters,
                                       std::span<const Detection> covered) {
  const QuarterTurn upright = clusters.upright;
  if (upright == QuarterTurn::kNone) return Uncovered(std::move(clusters.found), covered);
  std::vector<Detection> turned_covered;
  for (const Detection& detection : covered)
    turned_covered.push_back(Turned(detection, clusters.width, clusters.height, upright));
  std::vector<Detection> found = Uncovered(std::move(clusters.found), turned_covered);
  const bool on_its_side = OnItsSide(upright);
  const int turned_width = on_its_side ? clusters.height : clusters.width;
  const int turned_height = on_its_side ? clusters.width : clusters.height;
  for (Detection& detection : found)
    detection = Turned(std::move(detection), turned_width, turned_height, Inverse(upright));
  return found;
}

}  // namespace deepslam::detect
