// How far two surfaces are apart.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::mesh {

// Largest distance of a vertex or face centre of either mesh from the other mesh's surface: the
// symmetric Hausdorff distance up to the size of a face. Both must have faces, with indices in
// range and finite coordinates.
[[nodiscard]] double SurfaceDistance(const TriangleMesh& a, const TriangleMesh& b);

// Whether that distance is at most `bound`; much faster, since no nearest point is looked for.
[[nodiscard]] bool WithinDistance(const TriangleMesh& a, const TriangleMesh& b, double bound);

// Per point 1 where the surface of `mesh` is at most `distance` away, else 0. The mesh as above.
[[nodiscard]] std::vector<std::uint8_t> AreNear(std::span<const Eigen::Vector3f> points,
                                                const TriangleMesh& mesh,
                                                double distance);

}  // namespace deepslam::mesh
