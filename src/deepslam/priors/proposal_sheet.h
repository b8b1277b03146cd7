// Crops beside the shapes that were proposed for them, for people who assess networks.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/propose/network_crop.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::priors {

struct SeenShape {
  VoxelGrid shape;
  double azimuth_rad = 0;  // of the camera, 0 = in front (+x), counter-clockwise from above
  double elevation_rad = 0;
};

struct ProposalRow {
  propose::NetworkCrop crop;
  std::vector<std::optional<SeenShape>> shapes;  // as many in every row
};

// The shape from far away in that direction, darker where farther; 255 beside it.
// kCropSide x kCropSide.
[[nodiscard]] Image<std::uint8_t> DrawShape(const SeenShape& seen);

// A row each: crop, its depth, the shapes. White where there is none.
[[nodiscard]] ColourImage DrawProposalSheet(std::span<const ProposalRow> rows);

}  // namespace deepslam::priors
