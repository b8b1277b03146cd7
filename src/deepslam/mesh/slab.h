// Slabs with rectangular holes: the thin closed meshes that stand for walls, floors and ceilings.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::mesh {

// A rectangle of a slab's face.
struct SlabHole {
  double left_m = 0;
  double right_m = 0;
  double bottom_m = 0;
  double top_m = 0;
};

// x in [left_m, right_m], z in [bottom_m, top_m], y in [-thickness_m, 0]: the face at y = 0 is seen
// from y > 0.
struct Slab {
  double left_m = 0;
  double right_m = 0;
  double bottom_m = 0;
  double top_m = 0;
  double thickness_m = 0.05;
  std::vector<SlabHole> holes;  // what lies outside the slab or in another hole is passed over
  double step_m = 0.5;          // between vertices of the faces, at most
};

// Closed, oriented, two-manifold; without colours. Empty where the holes leave nothing or a size is
// not positive and finite. Where two holes meet in a corner alone, a cell beside it is filled.
[[nodiscard]] TriangleMesh MakeSlab(const Slab& slab);

// The mesh in the colours of the surface within `reach_m` of its face, by cells of `step_m`; on its
// other sides their mean. As it is where less than a tenth of the cells were seen.
struct SlabColours {
  double reach_m = 0.06;
  double step_m = 0.1;
};
void ColourSlab(const TriangleMesh& surface_world,
                const Pose3& world_from_slab,
                const SlabColours& options,
                TriangleMesh& mesh);

// A polygon (counter-clockwise, no holes) from z = 0 to z = `height_m`, closed. Errors: those of
// TriangulateOutline.
[[nodiscard]] Result<TriangleMesh> MakePrism(std::span<const Eigen::Vector2d> outline_m,
                                             double height_m);

}  // namespace deepslam::mesh
