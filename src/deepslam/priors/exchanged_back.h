// A seat with the back of another: more designs to learn from than there are products.
#pragma once

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::priors {

// Both in the canonical frame (z up, x front), metres. `mesh` as it is where one of them has
// nothing to sit on, where the two do not touch, or where what was solid is open now.
[[nodiscard]] TriangleMesh WithBackOf(const TriangleMesh& mesh, const TriangleMesh& other);

}  // namespace deepslam::priors
