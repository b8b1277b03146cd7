// A triangle mesh becomes a solid 64^3 model.
#pragma once

#include "deepslam/core/result.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

// Closed or open triangle soup, z up and x front, any unit -> solid model. Bounding box centred,
// longest side kModelExtent, aspect kept. What the outside reaches only through gaps narrower than
// a voxel is solid, so meshes with small holes still give solids. Parts thinner than a voxel stay
// and stay connected. Faces with an index out of range or a non-finite vertex are ignored. About
// 0.15 s. Error: no usable face, or an extent that is zero or not finite.
[[nodiscard]] Result<VoxelGrid> Voxelize(const TriangleMesh& mesh);

}  // namespace deepslam::shape
