// Where an image lies inside a network's input: scaled without distortion, the rest padded.
#pragma once

#include "deepslam/geometry/box.h"

namespace deepslam::detect {

enum class Padding {
  kCentred,  // YOLOv8, YOLO11: the same left and right, top and bottom
  kTopLeft,  // YOLOX: the image lies in the top left corner
};

// input = image * scale + pad, in continuous coordinates whose integers are the pixels' top left
// corners.
struct Letterbox {
  double scale = 1;
  int width_px = 0;  // of the scaled image inside the input
  int height_px = 0;
  int pad_u_px = 0;
  int pad_v_px = 0;
};

// Sizes are positive.
[[nodiscard]] Letterbox FitLetterbox(
    int image_width, int image_height, int input_width, int input_height, Padding padding);

// A box of the network's input in the image, clipped to it; empty where nothing is left.
[[nodiscard]] Box2 ToImage(const Letterbox& letterbox,
                           const Box2& box_input,
                           int image_width,
                           int image_height);

}  // namespace deepslam::detect
