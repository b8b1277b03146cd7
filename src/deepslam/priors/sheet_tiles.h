// Square pictures side by side.
#pragma once

#include <type_traits>

#include "deepslam/core/image.h"
#include "deepslam/propose/network_crop.h"

namespace deepslam::priors {

inline constexpr int kTileSide = propose::kCropSide;

// Magnifies by a whole factor what is smaller; an empty tile leaves its place as it is.
template <typename Pixel>
void PutTile(int column, int row, const Image<Pixel>& tile, ColourImage& sheet) {
  if (tile.empty()) return;
  const int factor = kTileSide / tile.width();
  for (int v = 0; v < kTileSide; ++v) {
    for (int u = 0; u < kTileSide; ++u) {
      const Pixel& pixel = tile(u / factor, v / factor);
      Rgb8& to = sheet(column * kTileSide + u, row * kTileSide + v);
      if constexpr (std::is_same_v<Pixel, Rgb8>) {
        to = pixel;
      } else {
        to = {pixel, pixel, pixel};
      }
    }
  }
}

}  // namespace deepslam::priors
