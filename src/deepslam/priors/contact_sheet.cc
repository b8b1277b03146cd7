#include "deepslam/priors/contact_sheet.h"

#include <algorithm>

#include "deepslam/priors/sheet_tiles.h"

namespace deepslam::priors {
namespace {

constexpr int kTilesInRow = 7;  // tiles of a row beside the crops

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
  ColourImage sheet((views + kTilesInRow) * kTileSide,
                    static_cast<int>(rows.size()) * kTileSide,
                    {255, 255, 255});
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const int row = static_cast<int>(n);
    for (std::size_t k = 0; k < rows[n].views.size(); ++k)
      PutTile(static_cast<int>(k), row, rows[n].views[k].crop.colour, sheet);
    if (!rows[n].views.empty()) {
      const TrainingView& view = rows[n].views.front();
      PutTile(views, row, view.crop.depth, sheet);
      PutTile(views + 1, row, view.crop.height, sheet);
      PutTile(views + 2, row, view.sketch.depth, sheet);
      PutTile(views + 3, row, view.sketch.normal, sheet);
      PutTile(views + 4, row, view.sketch.silhouette, sheet);
    }
    PutTile(views + 5, row, Shadow(rows[n].shape, true), sheet);
    PutTile(views + 6, row, Shadow(rows[n].shape, false), sheet);
  }
  return sheet;
}

}  // namespace deepslam::priors
