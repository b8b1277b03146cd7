#include "deepslam/priors/proposal_sheet.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "deepslam/priors/sheet_tiles.h"

namespace deepslam::priors {
namespace {

// A model's longest side, 62 voxels, takes 99 of the picture's 128 px.
constexpr double kPxPerVoxel = 1.6;
constexpr double kHalfGrid = 0.5 * kGridSize;  // voxels from the grid's corner to its middle

// Right, up and towards the camera, in the shape's frame.
Eigen::Matrix3d CameraAxes(const SeenShape& seen) {
  const double a = seen.azimuth_rad, e = seen.elevation_rad;
  Eigen::Matrix3d axes;
  axes.row(0) << -std::sin(a), std::cos(a), 0;
  axes.row(1) << -std::sin(e) * std::cos(a), -std::sin(e) * std::sin(a), std::cos(e);
  axes.row(2) << std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e);
  return axes;
}

}  // namespace

Image<std::uint8_t> DrawShape(const SeenShape& seen) {
  constexpr int kSheetSide = propose::kCropSide;
  Image<std::uint8_t> image(kSheetSide, kSheetSide, 255);
  Image<float> nearest(kSheetSide, kSheetSide, -1e9F);
  const Eigen::Matrix3d axes = CameraAxes(seen);
  for (int x = 0; x < kGridSize; ++x) {
    for (int y = 0; y < kGridSize; ++y) {
      for (int z = 0; z < kGridSize; ++z) {
        if (seen.shape.occupied[VoxelGrid::Index(x, y, z)] == 0) continue;
        const Eigen::Vector3d p =
            axes * (Eigen::Vector3d(x, y, z) + Eigen::Vector3d::Constant(0.5 - kHalfGrid));
        const int u0 = static_cast<int>(std::floor(0.5 * kSheetSide + kPxPerVoxel * p.x() - 1));
        const int v0 = static_cast<int>(std::floor(0.5 * kSheetSide - kPxPerVoxel * p.y() - 1));
        const float towards = static_cast<float>(p.z());
        const double grey = 120 + 110 * p.z() / kHalfGrid;
        for (int v = std::max(0, v0); v < std::min(kSheetSide, v0 + 3); ++v) {
          for (int u = std::max(0, u0); u < std::min(kSheetSide, u0 + 3); ++u) {
            if (nearest(u, v) >= towards) continue;
            nearest(u, v) = towards;
            image(u, v) = static_cast<std::uint8_t>(std::clamp(grey, 10.0, 235.0));
          }
        }
      }
    }
  }
  return image;
}

ColourImage DrawProposalSheet(std::span<const ProposalRow> rows) {
  const std::size_t num_shapes = rows.empty() ? 0 : rows.front().shapes.size();
  ColourImage sheet(static_cast<int>(num_shapes + 2) * kTileSide,
                    std::max(1, static_cast<int>(rows.size())) * kTileSide,
                    {255, 255, 255});
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const int row = static_cast<int>(n);
    PutTile(0, row, rows[n].crop.colour, sheet);
    PutTile(1, row, rows[n].crop.depth, sheet);
    for (std::size_t k = 0; k < rows[n].shapes.size(); ++k) {
      if (rows[n].shapes[k])
        PutTile(static_cast<int>(k) + 2, row, DrawShape(*rows[n].shapes[k]), sheet);
    }
  }
  return sheet;
}

}  // namespace deepslam::priors
