// A shape in as few bytes as its stated error allows: what map.json embeds of winners that neither a
// library nor a decoder makes again.
#pragma once

#include <string>

#include "deepslam/core/result.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::stages {

// How far an embedded shape may be from the scene's, in voxels of the object's 64^3 model.
inline constexpr double kEmbeddedErrorVoxels = 0.5;

// Draco bytes of a closed mesh in the metric object frame, without its colours: decimated and
// quantised as coarsely as leaves the decoded surface closed, oriented, two-manifold, free of
// self-intersections, in as many pieces, and within kEmbeddedErrorVoxels of the given one (Hausdorff,
// measured both ways after decoding). `scale_m`: metres per object unit. Errors: a mesh that is not
// closed.
[[nodiscard]] Result<std::string> EncodeCompactShape(const TriangleMesh& mesh_object_m,
                                                     double scale_m);

}  // namespace deepslam::stages
