// A closed mesh as convex pieces, for physics engines: they collide convex shapes, and the hull of
// a chair would fill the room under its seat.
#pragma once

#include <cstddef>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::convex {

struct DecomposeOptions {
  int max_pieces = 128;
  // The pieces' volumes may sum up to this much more than the mesh's.
  double tolerance = 0.05;
};
void Describe(OptionsVisitor& visitor, DecomposeOptions& options);

// The piece with the most air in its hull is cut in two by the best of BestCuts until the hulls'
// volumes are within the tolerance or there are `max_pieces`. Hulls of parts of a rough surface
// still hold air, and hulls of 64 vertices, which is what PhysX takes, lose some: the sides of each
// are then moved, by half a cell of a grid of 60 along the mesh at most, until it has the volume of
// the part of the mesh that it stands for. An open mesh gives its hull alone; one without a volume
// gives none. Deterministic.
[[nodiscard]] std::vector<TriangleMesh> Decompose(const TriangleMesh& mesh,
                                                  const DecomposeOptions& options);

}  // namespace deepslam::convex
