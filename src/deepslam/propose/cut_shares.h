// From the values of a network to a solid.
#pragma once

#include <span>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::propose {

// What is solid, on the decoder's own grid. `shares`: how likely each voxel is solid, calibrated
// (docs/priors.md), index order of VoxelGrid. Above `threshold` they are. That a leg is there is
// surer than where: its probability spreads over places and is nowhere above the threshold. So each
// horizontal layer keeps at least half as many voxels as are solid in it by expectation, the
// likeliest, but none below 5 %. Crumbs are left out. scripts/train/cut.py is the same.
[[nodiscard]] VoxelGrid CutShares(std::span<const float> shares, double threshold);

}  // namespace deepslam::propose
