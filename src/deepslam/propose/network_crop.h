// What a shape network sees of one view: the segmented object on white, in a square.
//
// Training views are cut by the same function, so that the networks meet in the chain what they
// were trained on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/propose/crop_camera.h"
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
  // 0: not known. Else 1 ... 255 for (depth - reference_m) / side_m in [-1, 1], 128 being 0.
  Image<std::uint8_t> depth;
  // Above the ground: 0 ... 255 for -0.1 m ... 2.45 m in steps of 1 cm; 0 where depth or ground is
  // not known.
  Image<std::uint8_t> height;
  CropCamera camera;
  std::optional<double> elevation_rad;  // how far the crop's camera looks down, by the ground
  double reference_m = 0;               // median depth of the silhouette; 0 = no depth
  double side_m = 0;                    // the square's side at that depth; 0 = no depth
};

// Depth is that along the axis of the crop's camera (crop_camera.h). Without `use_depth` the ground
// only says which way is up.
// Errors: no silhouette, one too small to show a shape, images of different sizes, no camera.
[[nodiscard]] Result<NetworkCrop> MakeNetworkCrop(const ObjectView& view, bool use_depth);

// The planes; `values` has kCropValues.
void FillPlanes(const NetworkCrop& crop, std::span<float> values);

}  // namespace deepslam::propose
