// A network's shape completed by what was measured: thin parts that no latents give, legs above
// all.
#pragma once

#include <span>
#include <vector>

#include "deepslam/refine/evidence.h"

namespace deepslam::refine {

// Makes the voxels that are surely solid so in `logits`, after these were brought down to the
// ground (shape::StandOnGround). One entry per voxel each, index order of VoxelGrid.
void AddMeasured(std::span<const Evidence> evidence,
                 int ground_k,
                 int max_gap,
                 std::vector<float>& logits);

}  // namespace deepslam::refine
