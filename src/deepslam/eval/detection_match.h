// What a detector found of what could be seen in a frame.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/geometry/box.h"

namespace deepslam::eval {

inline constexpr std::string_view kDetectionProtocol =
    "boxes by IoU 0.5 with the visible part's box; objects that cover 0.5 % of the frame";
inline constexpr double kDetectionIou = 0.5;  // as PASCAL VOC and COCO's AP50 match boxes

// A box in the image; of the truth: round the visible pixels of an object.
struct ImageBox {
  std::string class_name;
  Box2 box_px;
};

// Boxes round the pixels of each number 1 .. count of an instance mask; empty where fewer than
// `min_pixels` are there. Pixels are squares: a box's sides lie half a pixel outside their centres.
[[nodiscard]] std::vector<Box2> VisibleBoxes(const Image<std::uint16_t>& instances,
                                             int count,
                                             int min_pixels);

struct BoxMatch {
  std::size_t detected = 0;
  std::size_t truth = 0;
  bool same_class = false;
};
// Pairs with at least `min_iou`, each box once: pairs of one class before all others, then greatest
// overlap first. Ordered by truth.
[[nodiscard]] std::vector<BoxMatch> MatchBoxes(std::span<const ImageBox> detected,
                                               std::span<const ImageBox> truth,
                                               double min_iou);

}  // namespace deepslam::eval
