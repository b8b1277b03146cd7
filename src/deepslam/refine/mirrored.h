// Furniture is mostly like its mirror image: a side that nobody saw is then known by the other.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "deepslam/refine/evidence.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::refine {

// Across an axis of the grid: voxel n has voxel sum - n opposite.
struct MirrorPlane {
  int axis = 0;
  int sum = 0;
};

// The plane across `axis` in which what was measured is most like its mirror image, near the middle
// of `model`, the box of the model in the grid. Nothing where too little was seen on both sides to
// tell, or where what was measured on one side is free on the other.
[[nodiscard]] std::optional<MirrorPlane> FindMirrorPlane(std::span<const Votes> votes,
                                                         std::size_t num_views,
                                                         const VoxelBox& model,
                                                         int axis);

// The votes; to those of a voxel that tell neither free nor surface come those of the voxel
// opposite where these are sure: measured, or free by two of several views at least.
[[nodiscard]] std::vector<Votes> WithMirrored(const MirrorPlane& plane,
                                              std::span<const Votes> votes,
                                              std::size_t num_views);

// `mirrored` as far as it frees whole upright runs of the model's voxels that tell neither free nor
// surface in `seen`: all of a run where the other side is free along half of it at least, else
// nothing. A leg of which a part has an opposite would else be left in pieces. What the other side
// measured stays.
[[nodiscard]] std::vector<Votes> InWholeRuns(const VoxelGrid& model,
                                             std::span<const Votes> seen,
                                             std::span<const Votes> mirrored,
                                             std::size_t num_views);

}  // namespace deepslam::refine
