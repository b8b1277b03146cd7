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

Triangles TrianglesOf(const TriangleMesh& mesh) {
  Triangles triangles;
  triangles.reserve(mesh.faces.size());
  for (const auto& face : mesh.faces) {
    triangles.emplace_back(ToPoint(mesh.vertices[face[0]]),
                           ToPoint(mesh.vertices[face[1]]),
                           ToPoint(mesh.vertices[face[2]]));
  }
  return triangles;
}

// The used vertices of `from`, and the centres of its faces unless they are finer than those of `to`.
std::vector<Eigen::Vector3f> Samples(const TriangleMesh& from, const TriangleMesh& to) {
  std::vector<Eigen::Vector3f> samples;
  std::vector<std::uint8_t> used(from.vertices.size(), 0);
  const bool coarser = from.faces.size() <= to.faces.size();
  for (const auto& face : from.faces) {
    for (const std::uint32_t v : face) used[v] = 1;
    if (!coarser) continue;
    samples.emplace_back(
        (from.vertices[face[0]] + from.vertices[face[1]] + from.vertices[face[2]]) / 3.0F);
  }
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v] != 0) samples.push_back(from.vertices[v]);
  }
  return samples;
}

double OneSided(const TriangleMesh& from, const TriangleMesh& to) {
  const Triangles triangles = TrianglesOf(to);
  Tree tree(triangles.cbegin(), triangles.cend());
  tree.accelerate_distance_queries();
  double largest = 0;
  Kernel::Point_3 hint = triangles.front()[0];
  for (const Eigen::Vector3f& p : Samples(from, to)) {
    hint = tree.closest_point(ToPoint(p), hint);
    largest = std::max(largest, CGAL::squared_distance(ToPoint(p), hint));
  }
  return std::sqrt(largest);
}

// Answers for one mesh and one distance. Neighbouring points mostly lie by the same triangle, which is
// asked first.
class Nearness {
 public:
  Nearness(const TriangleMesh& mesh, double distance)
      : triangles_(TrianglesOf(mesh)),
        tree_(triangles_.cbegin(), triangles_.cend()),
        squared_(distance * distance),
        last_(triangles_.cbegin()) {
    tree_.build();
  }
  Nearness(const Nearness&) = delete;
  Nearness& operator=(const Nearness&) = delete;

  bool Holds(const Eigen::Vector3f& p) {
    const Kernel::Point_3 point = ToPoint(p);
    if (CGAL::squared_distance(point, *last_) <= squared_) return true;
    const auto found = tree_.any_intersected_primitive(Kernel::Sphere_3(point, squared_));
    if (found) last_ = *found;
    return found.has_value();
  }

 private:
  Triangles triangles_;
  Tree tree_;
  double squared_;
  Triangles::const_iterator last_;
};

bool OneSidedWithin(const TriangleMesh& from, const TriangleMesh& to, double bound) {
  Nearness nearness(to, bound);
  const std::vector<Eigen::Vector3f> samples = Samples(from, to);
  return std::all_of(
      samples.begin(), samples.end(), [&](const Eigen::Vector3f& p) { return nearness.Holds(p); });
}

}  // namespace

double SurfaceDistance(const TriangleMesh& a, const TriangleMesh& b) {
  return std::max(OneSided(a, b), OneSided(b, a));
}

bool WithinDistance(const TriangleMesh& a, const TriangleMesh& b, double bound) {
  return OneSidedWithin(a, b, bound) && OneSidedWithin(b, a, bound);
}

std::vector<std::uint8_t> AreNear(std::span<const Eigen::Vector3f> points,
                                  const TriangleMesh& mesh,
                                  double distance) {
  Nearness nearness(mesh, distance);
  std::vector<std::uint8_t> near;
  near.reserve(points.size());
  for (const Eigen::Vector3f& p : points) near.push_back(nearness.Holds(p) ? 1 : 0);
  return near;
}

}  // namespace deepslam::mesh
