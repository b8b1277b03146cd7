// Furniture of other proportions: longer legs, a deeper seat, wider arms, a back that leans more.
//
// Few products are free to learn from; a design and its relatives differ mostly in how far its
// parts reach. Frame of every mesh here: z up, x front, any origin, any unit.
#pragma once

#include "deepslam/core/random.h"
#include "deepslam/scene/triangle_mesh.h"

#include <Eigen/Core>

namespace deepslam::furniture {

// Places within the box, 0 to 1: what lies at `from` moves to `to`, and the rest with it, in
// proportion.
struct Bend {
  float from = 0.5F;  // within (0, 1)
  float to = 0.5F;    // within (0, 1)

  [[nodiscard]] float operator()(float at) const {
    return at < from ? at * to / from : 1 - (1 - at) * (1 - to) / (1 - from);
  }
};

// The box of what these make is not that of what they are made from.
struct Proportions {
  Eigen::Vector3f stretch = Eigen::Vector3f::Ones();  // along x, y, z
  Bend depth;                                         // along x
  Bend width;       // of the distance from the plane between right and left
  Bend height;      // along z
  float taper = 0;  // the top is wider and deeper by this share than the middle, the foot narrower
  float lean = 0;   // above `height.to` what is higher by 1 lies further behind by this
};

// What has a back leans; what stands against walls or carries things stays straight.
[[nodiscard]] Proportions DrawProportions(bool has_back, Random& random);

// Large faces are divided, so that all that touches stays together. Errors: none; no faces stay
// none.
[[nodiscard]] TriangleMesh Reproportion(const TriangleMesh& mesh, const Proportions& proportions);

}  // namespace deepslam::furniture
