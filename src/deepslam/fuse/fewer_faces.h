// Decimation of large surfaces by quadric errors (Garland and Heckbert 1997).
#pragma once

#include <cstddef>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::fuse {

// At most `max_faces` faces, on vertices of the mesh with their colours; indices must be in range.
// The surface keeps its topology as far as that number allows. Equal meshes give equal ones.
[[nodiscard]] TriangleMesh WithFewerFaces(TriangleMesh mesh, std::size_t max_faces);

}  // namespace deepslam::fuse
