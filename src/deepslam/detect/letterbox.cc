#include "deepslam/detect/letterbox.h"

#include <algorithm>
#include <cmath>

#include "deepslam/core/check.h"

namespace deepslam::detect {
namespace {

// The largest by which the image fits.
double Scale(Sides image, Sides input) {
  return std::min(static_cast<double>(input.width) / image.width,
                  static_cast<double>(input.height) / image.height);
}

}  // namespace

bool CanBeInput(std::int64_t width, std::int64_t height) {
  const auto can_be = [](std::int64_t side) {
    return side > 0 && side <= kLargestSide && side % kCoarsestStride_px == 0;
  };
  return can_be(width) && can_be(height);
}

Letterbox FitLetterbox(
    int image_width, int image_height, int input_width, int input_height, Padding padding) {
  DEEPSLAM_CHECK(image_width > 0 && image_height > 0 && input_width > 0 && input_height > 0,
                 "letterbox of an empty image");
  Letterbox fit;
  fit.scale = Scale({image_width, image_height}, {input_width, input_height});
  const auto scaled = [&](int side, int limit) {
    return std::clamp(static_cast<int>(std::lround(side * fit.scale)), 1, limit);
  };
  fit.width_px = scaled(image_width, input_width);
  fit.height_px = scaled(image_height, input_height);
  if (padding == Padding::kCentred) {
    fit.pad_u_px = (input_width - fit.width_px) / 2;
    fit.pad_v_px = (input_height - fit.height_px) / 2;
  }
  return fit;
}

Sides FitSides(Sides image, Sides input) {
  if (image.width <= 0 || image.height <= 0) return input;
  const double scale = Scale(image, input);
  const auto side = [&](int image_px, int input_px) {
    // An exact multiple of the stride must not become the next one.
    constexpr double kStrideRounding = 1e-9;
    const double strides = std::ceil(image_px * scale / kCoarsestStride_px - kStrideRounding);
    return std::clamp(static_cast<int>(strides) * kCoarsestStride_px, kCoarsestStride_px, input_px);
  };
  return {side(image.width, input.width), side(image.height, input.height)};
}

Box2 ToImage(const Letterbox& letterbox, const Box2& box_input, int image_width, int image_height) {
  // Pixel centres are integers in this program, corners in the network's: half a pixel between
  // them.
  const auto u = [&](double x) { return (x - letterbox.pad_u_px) / letterbox.scale - 0.5; };
  const auto v = [&](double y) { return (y - letterbox.pad_v_px) / letterbox.scale - 0.5; };
  const Box2 image = {0, 0, image_width - 1.0, image_height - 1.0};
  return Intersection(
      {u(box_input.u_min), v(box_input.v_min), u(box_input.u_max), v(box_input.v_max)}, image);
}

}  // namespace deepslam::detect
