// A user's detections in COCO form: a list of results or a whole dataset. It is foreign input,
// trusted in nothing.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/artifact/detections_json.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::artifact {

struct CocoDetections {
  // Ascending frames, source kFile, ids invalid (the caller numbers them), boxes clipped to the
  // image. Classes are the table's; entries with other labels, of no known image, or empty after
  // clipping are left out and counted.
  std::vector<Detection> detections;
  int num_unknown_class = 0;
  int num_unknown_image = 0;
  int num_unusable = 0;               // score or box out of range, mask of another size
  std::vector<std::string> warnings;  // the first few of each, with their place
};

// `images` are the capture's frames with the names of their colour files. An image_id is looked up
// in the document's `images` (by file name without folder and extension), else taken as a frame
// index; a string image_id is a file name. Classes come from category_name, from `categories`, or
// from the ids of COCO's 80 classes. Scores default to 1. Fails on text that is no COCO at all.
[[nodiscard]] Result<CocoDetections> ReadCocoFile(std::string_view text,
                                                  std::string_view name,
                                                  std::span<const DetectedImage> images,
                                                  const ClassTable& classes);

}  // namespace deepslam::artifact
