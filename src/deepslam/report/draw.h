// Pictures for the report: overlays on colour images, encoded as JPEG.
#pragma once

#include <span>
#include <string>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/geometry/box.h"

namespace deepslam::report {

// A box with its label, and the pixels that belong to it. An empty mask draws the box alone.
struct Overlay {
  Box2 box_px;
  Mask mask;  // size of the picture, or empty
  std::string label;
  Rgb8 colour;
};

// The picture with masks tinted, boxes and labels drawn, scaled down to at most `max_width_px`.
[[nodiscard]] Result<std::string> DrawOverlays(const ColourImage& picture,
                                               std::span<const Overlay> overlays,
                                               int max_width_px);

// A crop with the outline of a model (a mask of the same size) drawn in, scaled up or down to
// `width_px`.
[[nodiscard]] Result<std::string> DrawOutline(const ColourImage& crop,
                                              const Mask& model,
                                              Rgb8 colour,
                                              int width_px);

// Any picture as JPEG.
[[nodiscard]] Result<std::string> EncodeJpeg(const ColourImage& picture);

}  // namespace deepslam::report
