// Smoothing and decimation of a closed surface with a stated geometric bound.
#pragma once

#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::mesh {

struct RefineOptions {
  // Jacobi-Laplace steps before decimation; more of them would shrink thin legs.
  static constexpr int kSmoothingIterations = 2;
  double max_error =
      0.5 / 64;  // Hausdorff bound against the input, in the mesh's own unit: half a voxel
  double max_edge = 3.0 / 64;  // longest edge that decimation makes, own unit: colours stand at
                               // vertices, and a table top of two triangles would show none
  int target_faces = 2500;     // decimation stops here, or earlier where the bounds say so
};
void Describe(OptionsVisitor& visitor, RefineOptions& options);

// A closed, oriented two-manifold comes back as one, in the same unit and with as many components;
// the two surfaces stay within `max_error` of each other (measured afterwards, both ways). Where a
// result leaves the bound or would pierce itself, it is made again with half the steps' own bounds;
// in the worst case the input comes back. Colours are dropped. Errors: an empty mesh; one that is
// not closed, oriented and two-manifold.
[[nodiscard]] Result<TriangleMesh> RefineMesh(const TriangleMesh& mesh,
                                              const RefineOptions& options);

}  // namespace deepslam::mesh
