#include "deepslam/mesh/surface_distance.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace deepslam::mesh {
namespace {

// Distances need no exact predicates.
using Kernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 ToPoint(const Eigen::Vector3f& p) { return {p.x(), p.y(), p.z()}; }

double OneSided(const TriangleMesh& from, const TriangleMesh& to) {
  Triangles triangles;
  triangles.reserve(to.faces.size());
  for (const auto& face : to.faces) {
    triangles.emplace_back(ToPoint(to.vertices[face[0]]),
                           ToPoint(to.vertices[face[1]]),
                           ToPoint(to.vertices[face[2]]));
  }
  Tree tree(triangles.cbegin(), triangles.cend());
  tree.accelerate_distance_queries();
  double largest = 0;
  Kernel::Point_3 hint = triangles.front()[0];
  const auto measure = [&](const Eigen::Vector3f& p) {
    hint = tree.closest_point(ToPoint(p), hint);
    largest = std::max(largest, CGAL::squared_distance(ToPoint(p), hint));
  };
  std::vector<std::uint8_t> used(from.vertices.size(), 0);
  const bool coarser = from.faces.size() <= to.faces.size();
  for (const auto& face : from.faces) {
    for (const std::uint32_t v : face) used[v] = 1;
    if (!coarser) continue;
    measure((from.vertices[face[0]] + from.vertices[face[1]] + from.vertices[face[2]]) / 3.0F);
  }
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v] != 0) measure(from.vertices[v]);
  }
  return std::sqrt(largest);
}

}  // namespace

double SurfaceDistance(const TriangleMesh& a, const TriangleMesh& b) {
  return std::max(OneSided(a, b), OneSided(b, a));
}

}  // namespace deepslam::mesh
