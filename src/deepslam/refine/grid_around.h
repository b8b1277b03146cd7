// Grids that a completed model is carved in: upright and axis-parallel in the object frame, a layer
// of voxels beginning at the floor that the model stands on. Object units throughout.
#pragma once

#include <span>

#include "deepslam/geometry/similarity.h"
#include "deepslam/refine/evidence.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::refine {

// object_from_grid for the model and what `views` (grid = object frame) measured of the object
// within `reach` of it: of the model's own size where that is enough.
[[nodiscard]] Similarity3 GridAround(const shape::ShapeModel& model,
                                     std::span<const PlacedView> views,
                                     double reach);

// object_from_grid for what fills `box` of a grid, so that its longest side is kModelExtent there,
// to a voxel; `floor_z` in the object frame.
[[nodiscard]] Similarity3 GridOver(const VoxelBox& box,
                                   const Similarity3& object_from_grid,
                                   double floor_z);

// Whether the longest side is kModelExtent.
[[nodiscard]] bool IsOfModelSize(const VoxelBox& box);

}  // namespace deepslam::refine
