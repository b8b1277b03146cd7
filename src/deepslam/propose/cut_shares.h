// From the values of a network to a solid.
#pragma once

#include <span>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::propose {

// Where values end and a solid begins; calibrated for each class and kind of input.
struct SolidCut {
  double threshold = 0.5;
  double kept_of_expected = 0.5;  // in [0, 1]; 0 for classes that have no thin parts to lose
};

// What is solid, on the decoder's own grid. `shares`: how likely each voxel is solid, calibrated
// (docs/priors.md), index order of VoxelGrid. Above the threshold they are. That a leg is there is
// surer than where: its probability spreads over places and is nowhere above the threshold. So each
// horizontal layer keeps at least `kept_of_expected` times as many voxels as are solid in it by
// expectation, the likeliest, but none below 5 %. Small components are left out.
// scripts/train/cut.py is the same.
[[nodiscard]] VoxelGrid CutShares(std::span<const float> shares, const SolidCut& cut);

}  // namespace deepslam::propose
