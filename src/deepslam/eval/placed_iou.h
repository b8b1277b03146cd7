// Overlap of two solids where they stand: shape, size and place in one figure.
#pragma once

#include "deepslam/geometry/similarity.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::eval {

// Volume of the intersection over that of the union, counted at 128 points along the longest side
// of the box round both. Similarities map object units of the grids to world metres. 0 where both
// are empty.
[[nodiscard]] double PlacedIou(const VoxelGrid& a,
                               const Similarity3& world_from_a,
                               const VoxelGrid& b,
                               const Similarity3& world_from_b);

// Where the grid that shape::Voxelize makes of a mesh lies: mesh_from_grid. The mesh has faces with
// sound indices.
[[nodiscard]] Similarity3 MeshFromGrid(const TriangleMesh& mesh);

}  // namespace deepslam::eval
