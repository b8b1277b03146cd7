// What a model has below a surface although rays went through below that surface all round: a top
// that is thicker than the thing's, whose underside nobody saw.
#pragma once

#include <cstddef>
#include <span>

#include "deepslam/refine/evidence.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::refine {

// The model without the hidden parts of its layers (voxels that hang together in a layer and of
// which nobody knows whether they are free or surface) round which rays passed below a surface on
// most of the edge that was seen. `votes` by `num_views` views, index order of VoxelGrid.
[[nodiscard]] VoxelGrid WithoutPassedLayers(const VoxelGrid& model,
                                            std::span<const Votes> votes,
                                            std::size_t num_views);

}  // namespace deepslam::refine
