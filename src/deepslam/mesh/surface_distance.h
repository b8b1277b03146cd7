// How far two surfaces are apart.
#pragma once

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::mesh {

// Largest distance of a vertex or face centre of either mesh from the other mesh's surface: the
// symmetric Hausdorff distance up to the size of a face. Both must have faces, with indices in
// range and finite coordinates.
[[nodiscard]] double SurfaceDistance(const TriangleMesh& a, const TriangleMesh& b);

}  // namespace deepslam::mesh
