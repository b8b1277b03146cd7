// Models of other proportions: furniture of one design comes in many sizes.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/similarity.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

// The model stretched by `factors` (> 0) along its axes, then scaled and centred so that its
// longest side is kModelExtent again (centred to half a voxel). Thin parts stay connected. An empty
// grid stays empty.
[[nodiscard]] VoxelGrid StretchGrid(const VoxelGrid& grid, const Eigen::Vector3d& factors);

// grid_from_centred: where in a grid, of which `box` is occupied, lies what StretchGrid with
// factors of one made of it.
[[nodiscard]] Similarity3 GridFromCentred(const VoxelBox& box);

// The model turned about z by `quarter_turns` times 90 degrees counter-clockwise seen from above.
[[nodiscard]] VoxelGrid TurnGrid(const VoxelGrid& grid, int quarter_turns);

// Binary grid from the occupied share [0, 1] of each voxel: half-full voxels are occupied, and of
// the others as many as it takes to keep thin parts there and connected. Index order of VoxelGrid.
[[nodiscard]] VoxelGrid SolidFromShares(const std::vector<float>& shares);

// Occupied voxels in both / in either; 0 when both are empty.
[[nodiscard]] double GridIntersectionOverUnion(const VoxelGrid& a, const VoxelGrid& b);

}  // namespace deepslam::shape
