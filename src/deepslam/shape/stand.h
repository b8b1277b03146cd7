// What was measured of a thing, brought down to the ground it stands on.
#pragma once

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

// Segmentation takes this much of a thing's feet away with the ground, metres.
inline constexpr double kMaxFeetGapM = 0.1;

// What hangs at most `max_gap` layers above layer `ground_k` reaches down to it. A ground outside
// the grid is the grid's edge.
void StandOnGround(int ground_k, int max_gap, VoxelGrid& grid);

}  // namespace deepslam::shape
