// A user's detections.
#include <array>

#include "deepslam/artifact/coco_file.h"
#include "deepslam/class_table/class_table_yaml.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(coco) {
  static const ClassTable classes = class_table::DefaultClassTable();
  static const std::array<artifact::DetectedImage, 2> images = {
      artifact::DetectedImage{FrameIdx{0}, "rgb/000000.jpg", 64, 48},
      artifact::DetectedImage{FrameIdx{3}, "rgb/000003.jpg", 64, 48}};
  const auto found =
      artifact::ReadCocoFile([&] { return Result<TextSource>(bytes); }, kFile, images, classes);
  if (!found.ok()) return Refused(found.error());
  for (const Detection& detection : found->detections) {
    DEEPSLAM_CHECK(detection.score >= 0 && detection.score <= 1, "a score is a share");
    DEEPSLAM_CHECK(detection.box_px.width_px() >= 1 && detection.box_px.height_px() >= 1,
                   "a box holds a pixel");
    DEEPSLAM_CHECK(detection.mask.empty() || detection.mask.width() == 64, "a mask is an image's");
  }
  return !found->detections.empty();
}
