// The convex hull of points.
#pragma once

#include <span>

#include <Eigen/Core>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::convex {

// Closed, faces counter-clockwise seen from outside. Empty where the points span no volume. Points
// have to be finite.
[[nodiscard]] TriangleMesh ConvexHull(std::span<const Eigen::Vector3f> points);

// The same with `max_vertices` vertices at most: the ones that lie furthest out along directions
// spread evenly. Physics engines bound them (PhysX: 64).
[[nodiscard]] TriangleMesh BoundedHull(std::span<const Eigen::Vector3f> points,
                                       std::size_t max_vertices);

// The part of a convex mesh where normal . x <= offset; empty where nothing is left.
[[nodiscard]] TriangleMesh ClipConvex(const TriangleMesh& convex,
                                      const Eigen::Vector3d& normal,
                                      double offset);

}  // namespace deepslam::convex
