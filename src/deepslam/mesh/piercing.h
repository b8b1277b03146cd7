// Whether a closed surface runs through itself.
#pragma once

#include <optional>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::mesh {

// As SelfIntersects answers (see check_mesh.h), for closed manifolds alone: nothing for others.
// A face without area counts as piercing. Indices must be in range.
[[nodiscard]] std::optional<bool> PiercesItself(const TriangleMesh& mesh);

}  // namespace deepslam::mesh
