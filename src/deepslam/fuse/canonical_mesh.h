// One order of vertices and faces, whatever order they came in.
#pragma once

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::fuse {

// Vertices that no face uses go; the others in lexicographic order of place, then colour; faces
// rotated so that their lowest index is first, then sorted. Faces with two equal corners and
// doubled faces go.
[[nodiscard]] TriangleMesh CanonicalMesh(const TriangleMesh& mesh);

// Without the connected pieces that have fewer than `min_faces` faces.
[[nodiscard]] TriangleMesh WithoutSmallComponents(const TriangleMesh& mesh, int min_faces);

}  // namespace deepslam::fuse
