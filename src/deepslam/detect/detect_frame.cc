#include "deepslam/detect/detect_frame.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deepslam::detect {
namespace {

bool IsSane(const RawDetection& raw) {
  return std::isfinite(raw.score) && std::isfinite(raw.box_px.u_min) &&
         std::isfinite(raw.box_px.v_min) && std::isfinite(raw.box_px.u_max) &&
         std::isfinite(raw.box_px.v_max);
}

}  // namespace

void Describe(OptionsVisitor& visitor, DetectOptions& options) {
  visitor.Field(
      "min_score", options.min_score, {0, 1}, "1", "detections with a lower score are dropped");
}

std::vector<Detection> MapDetections(std::span<const RawDetection> raw,
                                     const Frame& frame,
                                     const ClassTable& classes,
                                     const DetectOptions& options) {
  const Box2 image = {0, 0, frame.colour.width() - 1.0, frame.colour.height() - 1.0};
  std::vector<Detection> found;
  for (const RawDetection& r : raw) {
    if (!IsSane(r) || r.score < options.min_score) continue;
    const ObjectClass* object_class = classes.FindByLabel(r.label);
    const Box2 box = Intersection(r.box_px, image);
    const bool large = !box.empty() && box.width_px() >= DetectOptions::kMinSide_px &&
                       box.height_px() >= DetectOptions::kMinSide_px;
    if (object_class == nullptr || !large) continue;
    Detection detection;
    detection.frame = frame.idx;
    detection.class_name = object_class->name;
    detection.score = std::min(1.0, r.score);
    detection.box_px = box;
    detection.mask = r.mask;
    found.push_back(std::move(detection));
  }
  std::stable_sort(found.begin(), found.end(), [](const Detection& a, const Detection& b) {
    return a.score > b.score;
  });
  std::vector<Detection> kept;
  for (Detection& candidate : found) {
    const bool repeated = std::any_of(kept.begin(), kept.end(), [&](const Detection& better) {
      const double limit = better.class_name == candidate.class_name ? DetectOptions::kSameClassIou
                                                                     : DetectOptions::kDuplicateIou;
      return IntersectionOverUnion(better.box_px, candidate.box_px) > limit;
    });
    if (!repeated) kept.push_back(std::move(candidate));
  }
  return kept;
}

Result<std::vector<Detection>> DetectFrame(const Detector& detector,
                                           const Frame& frame,
                                           const ClassTable& classes,
                                           const DetectOptions& options) {
  const Result<std::vector<RawDetection>> raw = detector.Detect(frame.colour);
  if (!raw.ok()) return raw.error();
  return MapDetections(*raw, frame, classes, options);
}

std::vector<const ObjectClass*> NeverDetected(const ClassTable& classes,
                                              const ClassTable& delivered,
                                              std::span<const std::string> detector_labels) {
  const auto known = [&](const std::string& label) {
    return std::ranges::find(detector_labels, label) != detector_labels.end();
  };
  std::vector<const ObjectClass*> never;
  for (const ObjectClass& c : classes.classes) {
    const ObjectClass* const as_delivered = delivered.Find(c.name);
    const bool own = as_delivered == nullptr || as_delivered->detector_labels != c.detector_labels;
    if (own && !c.detector_labels.empty() && std::ranges::none_of(c.detector_labels, known))
      never.push_back(&c);
  }
  return never;
}

}  // namespace deepslam::detect
