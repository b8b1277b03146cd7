// What of a grid's free voxels the outside reaches, 64 voxels at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

// The voxels (i, j, 0) to (i, j, 63) of every (i, j) at i * 64 + j, a bit each.
using VoxelRows = std::vector<std::uint64_t>;
static_assert(kGridSize == 64);
inline constexpr std::size_t kNumVoxelRows = std::size_t{kGridSize} * kGridSize;

// Those of `free` that steps through sides of free voxels lead to from the grid's rim.
[[nodiscard]] VoxelRows OutsideVoxels(const VoxelRows& free);

}  // namespace deepslam::shape
