// Where an image lies inside a network's input: scaled without distortion, the rest padded.
#pragma once

#include <cstdint>

#include "deepslam/geometry/box.h"

namespace deepslam::detect {

// Of a picture or a network's input, in pixels.
struct Sides {
  int width = 0;
  int height = 0;
  friend bool operator==(const Sides&, const Sides&) = default;
};

// Pixels, of a YOLO network's last level: sides are its multiples.
inline constexpr int kCoarsestStride_px = 32;
inline constexpr int kLargestSide = 4096;  // px; a model that asks for more is refused

// Multiples of the coarsest stride, up to the largest side.
[[nodiscard]] bool CanBeInput(std::int64_t width, std::int64_t height);

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

// The smallest input in which the image is as large as in `input`. An image without pixels fits
// every input.
[[nodiscard]] Sides FitSides(Sides image, Sides input);

// A box of the network's input in the image, clipped to it; empty where nothing is left.
[[nodiscard]] Box2 ToImage(const Letterbox& letterbox,
                           const Box2& box_input,
                           int image_width,
                           int image_height);

}  // namespace deepslam::detect
