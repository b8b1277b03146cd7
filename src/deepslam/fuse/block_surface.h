// The surface in a field of voxel blocks: where it is 0, between voxels that were all measured
// (Lorensen and Cline 1987; tables of Open3D).
#pragma once

#include "deepslam/fuse/voxel_blocks.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::fuse {

// World metres, coloured, faces towards the side that was seen free. Each crossed edge of the grid
// has one vertex; vertices and faces come in the order in which blocks were opened.
[[nodiscard]] TriangleMesh SurfaceOf(const VoxelBlocks& blocks);

}  // namespace deepslam::fuse
