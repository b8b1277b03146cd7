// The surface of a map object's shape: what stage `mesh` makes and `expand` makes again.
#pragma once

#include "deepslam/core/result.h"
#include "deepslam/mesh/extract_surface.h"
#include "deepslam/mesh/refine_mesh.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::stages {

// Closed, oriented, without colours, in the metric object frame.
[[nodiscard]] Result<TriangleMesh> MakeObjectMesh(const VoxelGrid& grid,
                                                  double scale_m,
                                                  const mesh::SurfaceOptions& surface,
                                                  const mesh::RefineOptions& refine);

}  // namespace deepslam::stages
