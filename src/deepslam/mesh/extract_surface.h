// From a 64^3 occupancy to a closed, oriented, two-manifold triangle surface without stair steps.
//
// The boundary of the voxels is taken as it is, made a manifold by filling the few voxels where the
// solid touches itself in an edge or a corner alone, and relaxed: every vertex seeks the place of
// least bending, but stays within half a voxel of its voxel corner (constrained elastic surface
// nets, Gibson 1998). Parts one or two voxels thick, and gaps as thin, get a narrower bound, so
// that legs neither vanish nor grow together. A face moves near its steps alone, which say that it
// slants: flat faces along the axes stay where they are, and sharp edges sharp.
#pragma once

#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::mesh {

struct SurfaceOptions {
  int iterations = 80;  // of the relaxation; 0 = the bare voxel boundary
  // Farthest a vertex may go from its voxel corner, per axis: half a voxel, what the grid leaves
  // open.
  static constexpr double kMaxShiftVoxels = 0.5;
  double min_component_share =
      0.01;  // parts with a smaller share of the occupied voxels are noise and go
};
void Describe(OptionsVisitor& visitor, SurfaceOptions& options);

// Object units (cube [-0.5, 0.5]^3), z up, faces counter-clockwise from outside, no colours.
// Cavities that the outside does not reach are filled. Separate parts stay separate closed
// components. Voxels at the cube's border are closed off. Errors: a grid with no occupied voxel; a
// grid of the wrong size.
[[nodiscard]] Result<TriangleMesh> ExtractSurface(const VoxelGrid& grid,
                                                  const SurfaceOptions& options);

}  // namespace deepslam::mesh
