#include "deepslam/convex/convex_hull.h"

#include <CGAL/convex_hull_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "deepslam/core/disjoint_sets.h"

namespace deepslam::convex {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

// Evenly spread over the sphere (Fibonacci's lattice), and the six axes, along which boxes end.
std::vector<Eigen::Vector3f> Directions(std::size_t number) {
  constexpr std::size_t kAxes = 6;  // both ways along x, y and z
  const std::size_t count = number > kAxes ? number - kAxes : 0;
  std::vector<Eigen::Vector3f> directions;
  for (int axis = 0; axis < 3; ++axis) {
    directions.push_back(Eigen::Vector3f::Unit(axis));
    directions.push_back(-Eigen::Vector3f::Unit(axis));
  }
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (std::size_t n = 0; n < count; ++n) {
    const double z = 1 - (2 * static_cast<double>(n) + 1) / static_cast<double>(count);
    const double radius = std::sqrt(1 - z * z);
    const double angle = golden * static_cast<double>(n);
    directions.emplace_back(static_cast<float>(radius * std::cos(angle)),
                            static_cast<float>(radius * std::sin(angle)),
                            static_cast<float>(z));
  }
  return directions;
}

// What makes directions even for points that lie flat or long as well: of a plate, most would find
// the same few points of its rim otherwise.
Eigen::Matrix3f StretchOf(std::span<const Eigen::Vector3f> points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : points) mean += p.cast<double>();
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3d off = p.cast<double>() - mean;
    spread += off * off.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  const double longest = solver.eigenvalues().z();
  if (!(longest > 0)) return Eigen::Matrix3f::Identity();
  // A thousandth of the length is as thin as anything measured is.
  const Eigen::Vector3d lengths = (solver.eigenvalues() / longest).cwiseMax(1e-6).cwiseSqrt();
  return (solver.eigenvectors() * lengths.cwiseInverse().asDiagonal() *
          solver.eigenvectors().transpose())
      .cast<float>();
}

// Vertices by their coordinates: CGAL numbers them by where they lie in memory.
void SortVertices(TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Eigen::Vector3f& p = mesh.vertices[a];
    const Eigen::Vector3f& q = mesh.vertices[b];
    return std::tuple(p.x(), p.y(), p.z()) < std::tuple(q.x(), q.y(), q.z());
  });
  std::vector<Eigen::Vector3f> sorted;
  std::vector<std::uint32_t> place(order.size());
  for (const std::uint32_t v : order) {
    place[v] = static_cast<std::uint32_t>(sorted.size());
    sorted.push_back(mesh.vertices[v]);
  }
  mesh.vertices = std::move(sorted);
  for (auto& face : mesh.faces) face = {place[face[0]], place[face[1]], place[face[2]]};
}

Kernel::Point_3 Exact(const Eigen::Vector3f& p) { return {p.x(), p.y(), p.z()}; }

using Edge = std::pair<std::uint32_t, std::uint32_t>;
using FacesOfEdges = std::map<Edge, std::uint32_t>;  // the face that goes along the edge

FacesOfEdges EdgesOf(const TriangleMesh& hull) {
  FacesOfEdges edges;
  for (std::uint32_t f = 0; f < hull.faces.size(); ++f) {
    for (std::size_t n = 0; n < 3; ++n) edges[{hull.faces[f][n], hull.faces[f][(n + 1) % 3]}] = f;
  }
  return edges;
}

// Triangles that lie in one plane are of one facet. Exact, so that it is the same whatever
// triangles a facet was cut into.
DisjointSets FacetsOf(const TriangleMesh& hull, const FacesOfEdges& edges) {
  DisjointSets facets(hull.faces.size());
  for (const auto& [edge, f] : edges) {
    const auto other = edges.find({edge.second, edge.first});
    if (other == edges.end() || other->second <= f) continue;
    for (const std::uint32_t v : hull.faces[other->second]) {
      if (v == edge.first || v == edge.second) continue;
      const auto& face = hull.faces[f];
      if (CGAL::coplanar(Exact(hull.vertices[face[0]]),
                         Exact(hull.vertices[face[1]]),
                         Exact(hull.vertices[face[2]]),
                         Exact(hull.vertices[v])))
        facets.Join(f, other->second);
    }
  }
  return facets;
}

// The facet's corners in turn, the first vertex first; without vertices that lie on an edge.
std::vector<std::uint32_t> CornersOf(const TriangleMesh& hull,
                                     const std::map<std::uint32_t, std::uint32_t>& next) {
  std::vector<std::uint32_t> loop = {next.begin()->first};
  while (loop.size() <= next.size()) {
    const auto step = next.find(loop.back());
    if (step == next.end() || step->second == loop.front()) break;
    loop.push_back(step->second);
  }
  std::vector<std::uint32_t> corners;
  for (std::size_t n = 0; n < loop.size(); ++n) {
    const std::uint32_t before = loop[(n + loop.size() - 1) % loop.size()];
    const std::uint32_t after = loop[(n + 1) % loop.size()];
    if (!CGAL::collinear(Exact(hull.vertices[before]),
                         Exact(hull.vertices[loop[n]]),
                         Exact(hull.vertices[after])))
      corners.push_back(loop[n]);
  }
  std::ranges::rotate(corners, std::ranges::min_element(corners));
  return corners;
}

// Facets cut into fans about their first corners, in order: which triangles CGAL cuts them into,
// and in which order, depends on where they lie in memory.
void CutFacetsAnew(TriangleMesh& hull) {
  const FacesOfEdges edges = EdgesOf(hull);
  DisjointSets facets = FacetsOf(hull, edges);
  std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> borders;
  for (const auto& [edge, f] : edges) {
    const auto other = edges.find({edge.second, edge.first});
    if (other == edges.end() || facets.LeastOf(other->second) != facets.LeastOf(f))
      borders[facets.LeastOf(f)][edge.first] = edge.second;
  }
  hull.faces.clear();
  for (const auto& [facet, next] : borders) {
    const std::vector<std::uint32_t> corners = CornersOf(hull, next);
    for (std::size_t n = 2; n < corners.size(); ++n)
      hull.faces.push_back({corners[0], corners[n - 1], corners[n]});
  }
  std::ranges::sort(hull.faces);
}

// Without vertices of no face; the order of the others stays.
void DropUnused(TriangleMesh& hull) {
  std::vector<bool> used(hull.vertices.size(), false);
  for (const auto& face : hull.faces) {
    for (const std::uint32_t v : face) used[v] = true;
  }
  std::vector<std::uint32_t> place(used.size(), 0);
  std::vector<Eigen::Vector3f> kept;
  for (std::size_t v = 0; v < used.size(); ++v) {
    place[v] = static_cast<std::uint32_t>(kept.size());
    if (used[v]) kept.push_back(hull.vertices[v]);
  }
  hull.vertices = std::move(kept);
  for (auto& face : hull.faces) face = {place[face[0]], place[face[1]], place[face[2]]};
}

}  // namespace

TriangleMesh ConvexHull(std::span<const Eigen::Vector3f> points) {
  TriangleMesh hull;
  if (points.size() < 4) return hull;
  std::vector<Kernel::Point_3> places;
  places.reserve(points.size());
  for (const Eigen::Vector3f& p : points) places.push_back(Exact(p));
  SurfaceMesh mesh;
  CGAL::convex_hull_3(places.begin(), places.end(), mesh);
  if (mesh.number_of_faces() < 4) return hull;  // flat
  for (const SurfaceMesh::Vertex_index v : mesh.vertices()) {
    const Kernel::Point_3& p = mesh.point(v);
    hull.vertices.emplace_back(
        static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  }
  for (const SurfaceMesh::Face_index f : mesh.faces()) {
    std::vector<std::uint32_t> corners;
    for (const SurfaceMesh::Vertex_index v : CGAL::vertices_around_face(mesh.halfedge(f), mesh))
      corners.push_back(static_cast<std::uint32_t>(v.idx()));
    for (std::size_t n = 2; n < corners.size(); ++n)
      hull.faces.push_back({corners[0], corners[n - 1], corners[n]});
  }
  SortVertices(hull);
  CutFacetsAnew(hull);
  DropUnused(hull);
  return hull;
}

TriangleMesh BoundedHull(std::span<const Eigen::Vector3f> points, std::size_t max_vertices) {
  if (points.size() <= max_vertices) return ConvexHull(points);
  const Eigen::Matrix3f stretch = StretchOf(points);
  std::set<std::size_t> chosen;
  for (const Eigen::Vector3f& even : Directions(max_vertices)) {
    const Eigen::Vector3f direction = stretch * even;
    std::size_t best = 0;
    float best_m = direction.dot(points[0]);
    for (std::size_t n = 1; n < points.size(); ++n) {
      const float way_m = direction.dot(points[n]);
      if (way_m <= best_m) continue;
      best_m = way_m;
      best = n;
    }
    chosen.insert(best);
  }
  std::vector<Eigen::Vector3f> outermost;
  for (const std::size_t n : chosen) outermost.push_back(points[n]);
  return ConvexHull(outermost);
}

TriangleMesh ClipConvex(const TriangleMesh& convex, const Eigen::Vector3d& normal, double offset) {
  std::vector<double> above;
  for (const Eigen::Vector3f& p : convex.vertices)
    above.push_back(normal.dot(p.cast<double>()) - offset);
  if (std::all_of(above.begin(), above.end(), [](double d) { return d <= 0; })) return convex;
  std::vector<Eigen::Vector3f> kept;
  for (std::size_t n = 0; n < above.size(); ++n) {
    if (above[n] <= 0) kept.push_back(convex.vertices[n]);
  }
  for (const auto& face : convex.faces) {
    for (std::size_t n = 0; n < 3; ++n) {
      const std::uint32_t a = face[n];
      const std::uint32_t b = face[(n + 1) % 3];
      if (!(above[a] < 0 && above[b] > 0)) continue;  // each edge is met once in this direction
      const double share = above[a] / (above[a] - above[b]);
      kept.push_back(convex.vertices[a] +
                     static_cast<float>(share) * (convex.vertices[b] - convex.vertices[a]));
    }
  }
  return ConvexHull(kept);
}

}  // namespace deepslam::convex
