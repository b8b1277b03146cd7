// What a shape network sees of one view: the segmented object on white, in a square.
//
// Training views are cut by the same function, so that the networks meet in the chain what they
// were trained on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::propose {

inline constexpr int kCropSide = 128;  // px
// Planes of a network's input, in this order: red, green, blue in [0, 1], white outside the
// silhouette; silhouette; relative depth, height above the ground (m), and 1 where depth is known.
// The last three are 0 where depth is not known, everywhere without depth.
inline constexpr int kCropPlanes = 7;
inline constexpr std::size_t kCropValues =
    static_cast<std::size_t>(kCropPlanes) * kCropSide * kCropSide;

// All images kCropSide x kCropSide.
struct NetworkCrop {
  ColourImage colour;              // white outside the silhouette
  Image<std::uint8_t> silhouette;  // share of the pixel, 0 ... 255
  // 0: not known. Else 1 ... 255 for (z - reference_m) / side_m in [-1, 1], 128 being 0.
  Image<std::uint8_t> depth;
  // Above the ground: 0 ... 255 for -0.1 m ... 2.45 m in steps of 1 cm; 0 where depth or ground is
  // not known.
  Image<std::uint8_t> height;
  // The square in the view's crop, set upright: its corner, which may lie outside, and side, pixels
  // of the view.
  double u0 = 0;
  double v0 = 0;
  double side_px = 0;
  double spread = 0;       // side_px over the focal length: how far lines of sight run apart
  double reference_m = 0;  // median depth of the silhouette; 0 = no depth
  double side_m = 0;       // the square's side at that depth; 0 = no depth
};

// The square is the silhouette's box made square and widened by a tenth. Where the ground of the
// view says that it lies on its side or upside down, it is turned by quarters until it stands.
// Errors: no silhouette, one too small to show a shape, images of different sizes.
[[nodiscard]] Result<NetworkCrop> MakeNetworkCrop(const ObjectView& view, bool use_depth);

// The planes; `values` has kCropValues.
void FillPlanes(const NetworkCrop& crop, std::span<float> values);

}  // namespace deepslam::propose
