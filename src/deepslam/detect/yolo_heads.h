// What the output tensors of the YOLO family mean. Pure functions on numbers: no network is needed
// to test them.
//
// yolov8     1 x (4 + C) x N            rows cx cy w h in input pixels, then C class scores
// (YOLOv8, YOLO11) yolov8seg  1 x (4 + C + M) x N        the same with M mask coefficients, and a
// second output 1 x M x h x w of
//                                       prototypes
// yolox      1 x N x (5 + C)            cx cy w h, objectness, C class scores; boxes either in
// input pixels or relative
//                                       to the cells of grids with strides 8, 16, 32: told apart by
//                                       their values
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/detect/letterbox.h"
#include "deepslam/geometry/box.h"

namespace deepslam::detect {

enum class HeadKind { kYoloV8, kYoloV8Seg, kYoloX };

struct HeadLayout {
  HeadKind kind = HeadKind::kYoloV8;
  int num_classes = 0;
  int num_cells = 0;         // N
  int num_coefficients = 0;  // M, kYoloV8Seg only
  int prototype_width = 0;
  int prototype_height = 0;
  int input_width = 0;
  int input_height = 0;
};

// A box in the network's input.
struct HeadBox {
  int label_idx = 0;
  double score = 0;
  Box2 box_input;
  std::vector<float> coefficients;  // of the mask
};

// Recognises the head by the shapes of all outputs. `num_names` is the number of labels in the
// metadata, 0 if unknown. InvalidInput lists the shapes when no head fits.
[[nodiscard]] Result<HeadLayout> RecogniseHead(
    std::span<const std::vector<std::int64_t>> output_shapes,
    int num_names,
    int input_width,
    int input_height);

// Boxes with score >= min_score, best first (equal scores: lower cell first). Entries that are
// not finite or have no area are left out. `output` has the layout's size.
[[nodiscard]] std::vector<HeadBox> DecodeHead(std::span<const float> output,
                                              const HeadLayout& layout,
                                              double min_score);

// Of boxes with one label that overlap by more than `max_iou` the first stays; at most `max_boxes`
// in all.
[[nodiscard]] std::vector<HeadBox> SuppressOverlaps(std::vector<HeadBox> boxes,
                                                    double max_iou,
                                                    int max_boxes);

// Instance mask in the image, inside `box_px` only: sigmoid(coefficients . prototypes) > 0.5,
// interpolated.
[[nodiscard]] Mask DecodeInstanceMask(std::span<const float> coefficients,
                                      std::span<const float> prototypes,
                                      const HeadLayout& layout,
                                      const Letterbox& letterbox,
                                      const Box2& box_px,
                                      int image_width,
                                      int image_height);

// Labels out of the metadata entry `names`: a Python or JSON dictionary {0: 'person', ...} or list
// ['person', ...]. Empty where it is neither.
[[nodiscard]] std::vector<std::string> ParseNames(std::string_view text);

// The 80 labels of COCO's detection task in the order every detector trained on it uses.
[[nodiscard]] const std::vector<std::string>& CocoLabels();

}  // namespace deepslam::detect
