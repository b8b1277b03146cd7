// The bounded piece of floor that was seen, as a flat polygon.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::mesh {

struct GroundPolygonOptions {
  // Points are thinned to one per cell of this size: the outline needs no more.
  static constexpr double kCell_m = 0.05;
  // Gaps in the floor narrower than twice this are bridged: the things that stand on it.
  static constexpr double kAlpha_m = 0.25;
  // The simplified outline may leave the points' by about this much, a cell.
  static constexpr double kSimplify_m = 0.06;
  // Points farther from the origin are refused as outliers: no home is as large.
  static constexpr double kMaxExtent_m = 200;
  double colour_step_m =
      0.05;  // between the points that carry the floor's colours; 0 = plain floor
};
void Describe(OptionsVisitor& visitor, GroundPolygonOptions& options);

// Points (x, y) on the ground plane in world metres -> the outline of the largest connected piece
// of their alpha shape, without holes, triangulated at z = 0, faces up (+z). Not finite points are
// left out. The order of points does not matter. Errors: fewer than three points that span an area.
[[nodiscard]] Result<TriangleMesh> GroundPolygon(std::span<const Eigen::Vector2d> points_world);

// The outline of such a mesh, counter-clockwise, beginning at its least point (by x, then y); empty
// for anything but a triangulated simple polygon.
[[nodiscard]] std::vector<Eigen::Vector2d> OutlineOf(const TriangleMesh& ground_polygon);

// The mesh of an outline, with `inner_m` as further vertices; they must lie well inside, so that
// the outline stays what it is. Errors: fewer than three points, not finite, crossing itself.
[[nodiscard]] Result<TriangleMesh> TriangulateOutline(
    std::span<const Eigen::Vector2d> outline_m, std::span<const Eigen::Vector2d> inner_m = {});

}  // namespace deepslam::mesh
