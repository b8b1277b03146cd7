// Holes of a top under what stands on it.
#pragma once

#include <cstddef>
#include <functional>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::refine {

// Fills small holes of wide layers through which no ray went: nobody saw the top there, for
// something stands on it. `is_free` takes a voxel's index; a hole with a free voxel is one.
void FillCoveredHoles(const std::function<bool(std::size_t)>& is_free, VoxelGrid& grid);

}  // namespace deepslam::refine
