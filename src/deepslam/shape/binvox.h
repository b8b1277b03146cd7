// Binvox bytes of a model, so that other programs open it.
//
// Binvox (Patrick Min) stores x slowest, then z, then y fastest: index (x * depth + z) * height +
// y, with y up in its own convention; deepslam's i, j, k (front, left, up) are written as binvox x,
// y, z, so viewers that know the format's order show the model's z as up. Header `#binvox 1`, `dim
// 64 64 64`, `translate`, `scale`, `data`, then pairs of bytes (value 0 or 1, count 1-255). The
// header's translate and scale place the grid in the unit cube: -0.5 -0.5 -0.5 and 1.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

[[nodiscard]] std::string WriteBinvox(const VoxelGrid& grid);
// Refuses anything but a 64^3 grid of values 0 and 1 of exactly the right length; reads no further
// than it must.
[[nodiscard]] Result<VoxelGrid> ReadBinvox(std::string_view bytes);

}  // namespace deepslam::shape
