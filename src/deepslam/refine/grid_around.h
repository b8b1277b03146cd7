// Grids that a completed model is carved in: upright and axis-parallel in the object frame, a layer
// of voxels beginning at the floor that the model stands on; or, where that is asked for and the
// object has a large level face, turned by 2 degrees at most so that a layer ends at it.
// Object units throughout.
#pragma once

#include <span>

#include "deepslam/geometry/similarity.h"
#include "deepslam/refine/evidence.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::refine {

struct ThingInViews {
  const shape::ShapeModel& model;
  std::span<const PlacedView> views;  // grid = object frame
  double reach = 0;                   // what was measured within it of the model is the object's
  bool follow_level_face = false;     // else a layer always begins at the floor
};

// object_from_grid for the model and what `views` measured of the object: of the model's own size
// where that is enough.
[[nodiscard]] Similarity3 GridAround(const ThingInViews& thing);

// object_from_grid for what fills `box` of a grid, so that its longest side is kModelExtent there,
// to a voxel.
[[nodiscard]] Similarity3 GridOver(const VoxelBox& box,
                                   const Similarity3& object_from_grid,
                                   const ThingInViews& thing);

// Whether the longest side is kModelExtent.
[[nodiscard]] bool IsOfModelSize(const VoxelBox& box);

}  // namespace deepslam::refine
