// Which side of a model is its front.
#pragma once

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

// Quarter turns (counter-clockwise from above, see TurnGrid) that bring the high back of a seat, or
// the head of a bed, to -x, so that the front is +x; 0 where nothing rises clearly on one side.
[[nodiscard]] int QuarterTurnsToFront(const VoxelGrid& grid);

}  // namespace deepslam::shape
