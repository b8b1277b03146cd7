// Exact Euclidean distance transform of a voxel grid (Felzenszwalb and Huttenlocher 2012).
#pragma once

#include <vector>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

// Squared distance, in voxels, from each voxel's centre to the centre of the nearest voxel whose
// occupancy equals `occupied`; a huge value (> 1e9) everywhere when there is none. Index order of
// VoxelGrid.
[[nodiscard]] std::vector<float> SquaredDistanceTo(const VoxelGrid& grid, bool occupied);

// Distance, in voxels, from each voxel's centre to the boundary between occupied and free voxels,
// < 0 in occupied ones; a huge value (> 1e4) where there is none. Index order of VoxelGrid.
[[nodiscard]] std::vector<float> SignedDistance(const VoxelGrid& grid);

}  // namespace deepslam::shape
