// Small loose parts of a voxel grid.
#pragma once

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

// The grid without its parts of fewer than `min_share` of all occupied voxels. Voxels at most
// `reach` (>= 1) steps apart along each axis hang together; 1: 26-connected.
[[nodiscard]] VoxelGrid WithoutCrumbs(const VoxelGrid& grid, int reach, double min_share);

}  // namespace deepslam::shape
