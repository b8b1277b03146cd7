// A network's shape completed by what was measured: thin parts that no latents give, legs above
// all.
#pragma once

#include <span>
#include <vector>

#include "deepslam/refine/evidence.h"

namespace deepslam::refine {

// Makes the voxels that are surely solid so in `logits`. Segmentation takes the ground away and a
// few centimetres of feet with it: what ends at most `max_gap` layers above layer `ground_k`
// reaches down to it. Index order of VoxelGrid.
void AddMeasured(std::span<const Evidence> evidence,
                 int ground_k,
                 int max_gap,
                 std::vector<float>& logits);

}  // namespace deepslam::refine
