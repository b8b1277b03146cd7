// A user's detections in COCO form: a list of results or a whole dataset. It is foreign input,
// trusted in nothing.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/artifact/coco_losses.h"
#include "deepslam/artifact/detections_json.h"
#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::artifact {

struct CocoDetections {
  // Ascending frames, source kFile, ids invalid (the caller numbers them), boxes and masks of the
  // frame's size, boxes clipped to it. Classes are the table's; entries with other labels, of no
  // known image, or empty after clipping are left out and counted. None is a result, too.
  std::vector<Detection> detections;
  CocoLosses losses;
  std::vector<std::string> warnings;  // the first few, with their place, and how many more
};

// px; zero where nothing is known.
struct PictureSize {
  int width = 0;
  int height = 0;
  friend bool operator==(const PictureSize&, const PictureSize&) = default;
};

// `images` are the capture's frames with the names of their colour files. An image_id is looked up
// in the document's `images` (by file name without folder and extension), else taken as a frame
// index; a string image_id is a file name. Classes come from category_name, from `categories`, or
// from the ids of COCO's 80 classes. Scores default to 1. Fails on text that is no COCO at all.
//
// Boxes and masks are of images as large as the document's `images` say; where they say nothing, as
// large as the entry's mask if that is the frame's size, else as the capture's `colour` images,
// else as the frame. Frames may be smaller (colour that is finer than depth is reduced): what is
// found is scaled to them, u -> (u + 0.5) * frame width / image width - 0.5. A warning tells when
// width and height scale differently.
//
// The text is opened twice and read by pieces: what its entries mean may stand behind them.
using OpenedText = std::function<Result<TextSource>()>;
[[nodiscard]] Result<CocoDetections> ReadCocoFile(const OpenedText& open,
                                                  std::string_view name,
                                                  std::span<const DetectedImage> images,
                                                  const ClassTable& classes,
                                                  const PictureSize& colour = {});

}  // namespace deepslam::artifact
