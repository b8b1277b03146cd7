// Checks of surfaces: topology (shape/mesh_check.h) and self-intersection.
#pragma once

#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/shape/mesh_check.h"

namespace deepslam::mesh {

using shape::CheckMesh;
using shape::MeshCheck;

// True when two faces that share no vertex cross, or neighbours overlap (exact predicates); true as
// well when the faces do not make a manifold. Indices must be in range.
[[nodiscard]] bool SelfIntersects(const TriangleMesh& mesh);

}  // namespace deepslam::mesh
