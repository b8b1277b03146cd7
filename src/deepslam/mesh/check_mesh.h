// Checks of surfaces: topology (scene/mesh_check.h) and self-intersection.
#pragma once

#include "deepslam/scene/mesh_check.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::mesh {

using deepslam::CheckMesh;
using deepslam::MeshCheck;

// True when two faces that share no vertex cross, or neighbours overlap (exact predicates); true as
// well when the faces do not make a manifold. Indices must be in range.
[[nodiscard]] bool SelfIntersects(const TriangleMesh& mesh);

}  // namespace deepslam::mesh
