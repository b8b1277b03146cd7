// Which side of a model is its front.
#pragma once

#include <optional>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

// Quarter turns (counter-clockwise from above, see TurnGrid) that bring the high back of a seat, or
// the head of a bed, to -x, so that the front is +x; 0 where nothing rises clearly on one side.
[[nodiscard]] int QuarterTurnsToFront(const VoxelGrid& grid);

// The same of a shape of which some sides were not seen, and nothing where no back shows: what
// rises on one side counts only where more than that side was measured below it.
[[nodiscard]] std::optional<int> QuarterTurnsFromHighBack(const VoxelGrid& grid);

}  // namespace deepslam::shape
