// detections.json: boxes and masks in the COCO layout (images, categories, annotations), with
// scores, so that COCO tools open it. Image ids are frame indices. doubts.json: why they make the
// whole run's result doubtful, sentences for people.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::artifact {

// A frame the detector looked at, whether or not it found something.
struct DetectedImage {
  FrameIdx frame;
  std::string file_name;
  int width = 0;   // px
  int height = 0;  // px
  // A network saw a person: such frames are shown nowhere. Nothing when no network looked.
  std::optional<bool> contains_person = {};
  friend bool operator==(const DetectedImage&, const DetectedImage&) = default;
};

struct DetectionTable {
  std::vector<DetectedImage> images;  // ascending frames
  std::vector<Detection> detections;  // ascending ids
};

[[nodiscard]] Result<std::string> EncodeDetections(const DetectionTable& table,
                                                   std::string_view name);
[[nodiscard]] Result<DetectionTable> DecodeDetections(TextSource text, std::string_view name);

[[nodiscard]] Result<std::string> EncodeDoubts(const std::vector<std::string>& doubts,
                                               std::string_view name);
[[nodiscard]] Result<std::vector<std::string>> DecodeDoubts(TextSource text, std::string_view name);

}  // namespace deepslam::artifact
