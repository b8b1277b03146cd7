// A model completed by what was measured of the object: thin parts that no latents give, and where
// a model of another design differs.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/refine/evidence.h"
#include "deepslam/refine/refine_options.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::refine {

struct CompletedModel {
  VoxelGrid grid;  // canonical: centred, longest side kModelExtent
  // Into the frame of the model that was completed, whose unit is that model's.
  Similarity3 model_from_grid;
};

// Planes of the object frame in its unit.
struct Limits {
  // Normals to the side of the cameras: nothing is behind them, but for walls that the views
  // measured the object behind, as through a door, or that most of the model is behind.
  std::vector<Plane> walls;
  // Normals inwards: what was measured beyond them is of something else, or the scatter of depth
  // along the rays, which reaches past every edge.
  std::vector<Plane> sides;
  // The level face of a support plane, normal down. What carries it stands under it: where the
  // views saw a side of it end, the model ends there as well.
  std::optional<Plane> top;
};

// A whole model where the views say nothing, what they measured where they do: voxels that more
// rays went through than found any surface in are taken from it, those that two views at least
// measured within options.reach_m of it are added and reach down to its lowest layer as
// shape::StandOnGround has it, shells are filled where nobody can see between their sides, small
// loose parts are left out, and what would hang in the air keeps the model's legs. What nobody saw
// is the model's only where no rays passed below (passed_layers.h), and like the other side where
// the thing is like its mirror image (mirrored.h): what that side adds begins a voxel off the
// model. Small holes of tops that something covers are filled (covered_holes.h). `views` say where
// the model stands (grid = object frame). Nothing where no view is usable or nothing is left.
[[nodiscard]] std::optional<CompletedModel> CompleteModel(const shape::ShapeModel& model,
                                                          std::span<const PlacedView> views,
                                                          const RefineOptions& options,
                                                          const Limits& limits = {});

}  // namespace deepslam::refine
