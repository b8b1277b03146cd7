// The surfaces of map objects: what stage `mesh` makes and `expand` makes again.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/mesh/extract_surface.h"
#include "deepslam/mesh/refine_mesh.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::mesh {

struct ObjectMeshOptions {
  SurfaceOptions surface;
  RefineOptions refine;
};

// Closed, oriented, without colours, in the metric object frame.
[[nodiscard]] Result<TriangleMesh> MakeObjectMesh(const VoxelGrid& grid,
                                                  double scale_m,
                                                  const ObjectMeshOptions& options);

// The same of several objects side by side, in their order; Interrupted() of those that were not
// begun when `stop_requested` said so.
[[nodiscard]] std::vector<Result<TriangleMesh>> MakeObjectMeshes(
    std::span<const VoxelGrid> grids,
    std::span<const double> scales_m,
    const ObjectMeshOptions& options,
    const std::function<bool()>& stop_requested);

}  // namespace deepslam::mesh
