// The parts of a voxel grid that do not hang together, and the small ones among them.
#pragma once

#include <cstddef>
#include <vector>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

// Indices of the occupied voxels of each part, in the order of the parts' first voxels. Voxels at
// most `reach` (>= 1) steps apart along each axis hang together; 1: 26-connected.
[[nodiscard]] std::vector<std::vector<std::size_t>> PartsOf(const VoxelGrid& grid, int reach);

// The grid without its parts of fewer than `min_share` of all occupied voxels.
[[nodiscard]] VoxelGrid WithoutSmallComponents(const VoxelGrid& grid, int reach, double min_share);

}  // namespace deepslam::shape
