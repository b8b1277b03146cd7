#include "deepslam/priors/contact_sheet.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace deepslam::priors {
namespace {

constexpr int kTile = propose::kCropSide;
constexpr int kPlaces = 7;  // tiles of a row beside the crops

Rgb8 Grey(int value) {
  const auto g = static_cast<std::uint8_t>(std::clamp(value, 0, 255));
  return {g, g, g};
}

template <typename Pixel>
void Put(int column, int row, const Image<Pixel>& tile, ColourImage& sheet) {
  const int factor = kTile / tile.width();
  for (int v = 0; v < kTile; ++v) {
    for (int u = 0; u < kTile; ++u) {
      const Pixel& pixel = tile(u / factor, v / factor);
      if constexpr (std::is_same_v<Pixel, Rgb8>) {
        sheet(column * kTile + u, row * kTile + v) = pixel;
      } else {
        sheet(column * kTile + u, row * kTile + v) = Grey(pixel);
      }
    }
  }
}

Image<std::uint8_t> Shadow(const VoxelGrid& shape, bool from_front) {
  Image<std::uint8_t> image(kGridSize, kGridSize, 255);
  for (int a = 0; a < kGridSize; ++a) {
    for (int k = 0; k < kGridSize; ++k) {
      int behind = 0;
      for (int b = 0; b < kGridSize; ++b)
        behind +=
            shape.occupied[from_front ? VoxelGrid::Index(b, a, k) : VoxelGrid::Index(a, b, k)];
      if (behind == 0) continue;
      // Seen from +x the object's left (+y) is on the right; seen from +y its front is on the left.
      const int u = from_front ? a : kGridSize - 1 - a;
      image(u, kGridSize - 1 - k) = static_cast<std::uint8_t>(std::max(0, 190 - 6 * behind));
    }
  }
  return image;
}

}  // namespace

ColourImage DrawContactSheet(std::span<const SheetRow> rows) {
  std::size_t most_views = 1;
  for (const SheetRow& row : rows) most_views = std::max(most_views, row.views.size());
  const int views = static_cast<int>(most_views);
  ColourImage sheet(
      (views + kPlaces) * kTile, static_cast<int>(rows.size()) * kTile, {255, 255, 255});
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const int row = static_cast<int>(n);
    for (std::size_t k = 0; k < rows[n].views.size(); ++k)
      Put(static_cast<int>(k), row, rows[n].views[k].crop.colour, sheet);
    if (!rows[n].views.empty()) {
      const TrainingView& view = rows[n].views.front();
      Put(views, row, view.crop.depth, sheet);
      Put(views + 1, row, view.crop.height, sheet);
      Put(views + 2, row, view.sketch.depth, sheet);
      Put(views + 3, row, view.sketch.normal, sheet);
      Put(views + 4, row, view.sketch.silhouette, sheet);
    }
    Put(views + 5, row, Shadow(rows[n].shape, true), sheet);
    Put(views + 6, row, Shadow(rows[n].shape, false), sheet);
  }
  return sheet;
}

}  // namespace deepslam::priors
