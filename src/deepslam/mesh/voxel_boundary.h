// The boundary of a solid of voxels as a manifold quad mesh, with what its relaxation needs.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::mesh {

// Two vertices on opposite sides of a thin part or a thin gap: along `axis`, `high` lies `width`
// voxels above `low`.
struct ThinPair {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  int axis = 0;
  int width = 0;
};

struct VoxelBoundary {
  std::vector<Eigen::Vector3d>
      vertices;  // voxel corners, in voxels; voxel (i, j, k) is [i, i+1] x ...
  std::vector<std::array<std::uint32_t, 4>> quads;  // counter-clockwise from outside
  std::vector<ThinPair> thin_pairs;                 // solid or gap of at most kThinVoxels
  // Per vertex and axis: 1 where a face across the axis ends at a concave edge, as at the foot of a
  // step.
  std::vector<std::array<std::uint8_t, 3>> at_step;
};

// Voxels: boards and gaps between them that smoothing would close.
inline constexpr int kThinVoxels = 2;

// Fills cavities, drops parts below `min_component_share` of all solid voxels (the largest always
// stays), and fills voxels until the solid is well-composed (Latecki 1997): it touches itself in
// faces only, so its boundary is a two-manifold.
[[nodiscard]] Result<VoxelBoundary> ExtractVoxelBoundary(const VoxelGrid& grid,
                                                         double min_component_share);

}  // namespace deepslam::mesh
