#include "deepslam/mesh/ground_polygon.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_2.h>
#include <CGAL/Polyline_simplification_2/simplify.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace deepslam::mesh {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;
using Polygon = CGAL::Polygon_2<Kernel>;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using FaceBase = CGAL::Triangulation_face_base_with_info_2<int, Kernel>;
using Delaunay =
    CGAL::Delaunay_triangulation_2<Kernel,
                                   CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>>;
using ConstrainedFaceBase = CGAL::Constrained_triangulation_face_base_2<Kernel, FaceBase>;
using Constrained = CGAL::Constrained_Delaunay_triangulation_2<
    Kernel,
    CGAL::Triangulation_data_structure_2<VertexBase, ConstrainedFaceBase>>;

// One point per cell, the mean, in the order of the cells: neither order nor density of the input
// matters.
std::vector<Point> Thinned(std::span<const Eigen::Vector2d> points) {
  std::map<std::pair<long, long>, std::vector<std::pair<double, double>>> cells;
  for (const Eigen::Vector2d& p : points) {
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > GroundPolygonOptions::kMaxExtent_m) continue;
    cells[{std::lround(p.x() / GroundPolygonOptions::kCell_m),
           std::lround(p.y() / GroundPolygonOptions::kCell_m)}]
        .emplace_back(p.x(), p.y());
  }
  std::vector<Point> result;
  result.reserve(cells.size());
  for (auto& [cell, members] : cells) {
    std::sort(members.begin(), members.end());
    double x = 0;
    double y = 0;
    for (const auto& [px, py] : members) {
      x += px;
      y += py;
    }
    const double count = static_cast<double>(members.size());
    result.emplace_back(x / count, y / count);
  }
  return result;
}

// Labels the connected pieces of faces with a circumradius of at most alpha: 1, 2, ...; 0 =
// outside. Returns the piece with the largest area; 0 when there is none.
int LabelAlphaShape(Delaunay& triangulation, double alpha_m) {
  for (const auto face : triangulation.all_face_handles()) face->info() = 0;
  const auto inside = [&](const Delaunay::Face_handle& face) {
    if (triangulation.is_infinite(face)) return false;
    const auto& t = triangulation.triangle(face);
    return CGAL::squared_radius(t[0], t[1], t[2]) <= alpha_m * alpha_m;
  };
  int label = 0;
  int largest = 0;
  double largest_area = 0;
  for (const auto seed : triangulation.finite_face_handles()) {
    if (seed->info() != 0 || !inside(seed)) continue;
    ++label;
    double area = 0;
    std::vector<Delaunay::Face_handle> stack = {seed};
    seed->info() = label;
    while (!stack.empty()) {
      const Delaunay::Face_handle face = stack.back();
      stack.pop_back();
      area += triangulation.triangle(face).area();
      for (int n = 0; n < 3; ++n) {
        const Delaunay::Face_handle next = face->neighbor(n);
        if (next->info() != 0 || !inside(next)) continue;
        next->info() = label;
        stack.push_back(next);
      }
    }
    if (area > largest_area) {
      largest_area = area;
      largest = label;
    }
  }
  return largest;
}

using Outgoing = std::map<Point, std::vector<Point>>;

// Boundary edges of a piece by their start, the piece to the left.
Outgoing BoundaryEdges(const Delaunay& triangulation, int label) {
  Outgoing outgoing;
  for (const auto face : triangulation.finite_face_handles()) {
    if (face->info() != label) continue;
    for (int n = 0; n < 3; ++n) {
      if (face->neighbor(n)->info() == label) continue;
      outgoing[face->vertex(Delaunay::ccw(n))->point()].push_back(
          face->vertex(Delaunay::cw(n))->point());
    }
  }
  return outgoing;
}

// The boundary loop with the largest enclosed area, counter-clockwise: the others are holes. Where
// loops touch in a vertex they are cut apart there, so that every loop is simple.
Polygon OuterBoundary(const Delaunay& triangulation, int label) {
  Outgoing outgoing = BoundaryEdges(triangulation, label);
  Polygon best;
  while (!outgoing.empty()) {
    std::vector<Point> path = {outgoing.begin()->first};
    std::map<Point, std::size_t> place = {{path[0], 0}};
    while (!path.empty()) {
      const auto found = outgoing.find(path.back());
      if (found == outgoing.end()) break;
      const Point next = found->second.back();
      found->second.pop_back();
      if (found->second.empty()) outgoing.erase(found);
      const auto met = place.find(next);
      if (met == place.end()) {
        place[next] = path.size();
        path.push_back(next);
        continue;
      }
      const std::size_t begin = met->second;
      const Polygon loop(path.begin() + static_cast<std::ptrdiff_t>(begin), path.end());
      if (loop.size() >= 3 && loop.area() > best.area()) best = loop;
      for (std::size_t n = begin + 1; n < path.size(); ++n) place.erase(path[n]);
      path.resize(begin + 1);
    }
  }
  return best;
}

Polygon Simplified(const Polygon& outline, double tolerance_m) {
  namespace ps = CGAL::Polyline_simplification_2;
  const ps::Stop_above_cost_threshold stop(tolerance_m * tolerance_m);
  const Polygon simple = ps::simplify(outline, ps::Squared_distance_cost(), stop);
  return simple.size() >= 3 && simple.is_simple() ? simple : outline;
}

// Faces across constrained edges change sides: flood from the infinite face.
void MarkInside(Constrained& triangulation) {
  for (const auto face : triangulation.all_face_handles()) face->info() = -1;
  std::vector<Constrained::Face_handle> current = {triangulation.infinite_face()};
  for (int depth = 0; !current.empty(); ++depth) {
    std::vector<Constrained::Face_handle> border;
    while (!current.empty()) {
      const Constrained::Face_handle face = current.back();
      current.pop_back();
      if (face->info() != -1) continue;
      face->info() = depth;
      for (int n = 0; n < 3; ++n) {
        if (face->neighbor(n)->info() != -1) continue;
        (face->is_constrained(n) ? border : current).push_back(face->neighbor(n));
      }
    }
    current = std::move(border);
  }
}

TriangleMesh Triangulated(const Polygon& outline, std::span<const Eigen::Vector2d> inner = {}) {
  Constrained triangulation;
  triangulation.insert_constraint(outline.vertices_begin(), outline.vertices_end(), true);
  for (const Eigen::Vector2d& p : inner) triangulation.insert(Point(p.x(), p.y()));
  MarkInside(triangulation);
  TriangleMesh mesh;
  for (const auto v : triangulation.finite_vertex_handles()) {
    v->info() = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.emplace_back(
        static_cast<float>(v->point().x()), static_cast<float>(v->point().y()), 0.0F);
  }
  for (const auto face : triangulation.finite_face_handles()) {
    if (face->info() % 2 == 0) continue;
    mesh.faces.push_back(
        {face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  }
  return mesh;
}

}  // namespace

Result<TriangleMesh> GroundPolygon(std::span<const Eigen::Vector2d> points_world) {
  try {
    const std::vector<Point> points = Thinned(points_world);
    Delaunay triangulation(points.begin(), points.end());
    const int label = triangulation.dimension() < 2
                          ? 0
                          : LabelAlphaShape(triangulation, GroundPolygonOptions::kAlpha_m);
    if (label == 0) {
      return InvalidInput("ground polygon: " + std::to_string(points.size()) +
                          " distinct points span no area");
    }
    const Polygon outline = OuterBoundary(triangulation, label);
    if (outline.size() < 3) return Failed("ground polygon: the outline is not simple");
    return Triangulated(Simplified(outline, GroundPolygonOptions::kSimplify_m));
  } catch (const std::exception& e) {
    return Failed(std::string("ground polygon: ") + e.what());
  }
}

std::vector<Eigen::Vector2d> OutlineOf(const TriangleMesh& ground_polygon) {
  // Edges whose other direction no face has, by their start.
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& face : ground_polygon.faces) {
    for (std::size_t n = 0; n < 3; ++n) edges.emplace(face[n], face[(n + 1) % 3]);
  }
  std::map<std::uint32_t, std::uint32_t> next;
  for (const auto& [from, to] : edges) {
    if (edges.contains({to, from})) continue;
    if (from >= ground_polygon.vertices.size() || !next.emplace(from, to).second) return {};
  }
  if (next.empty()) return {};
  const auto place = [&](std::uint32_t v) -> Eigen::Vector2d {
    return ground_polygon.vertices[v].head<2>().cast<double>();
  };
  std::uint32_t first = next.begin()->first;
  for (const auto& [from, to] : next) {
    const Eigen::Vector2d a = place(from);
    const Eigen::Vector2d b = place(first);
    if (a.x() < b.x() || (a.x() == b.x() && a.y() < b.y())) first = from;
  }
  std::vector<Eigen::Vector2d> outline;
  std::uint32_t at = first;
  do {
    outline.push_back(place(at));
    const auto found = next.find(at);
    if (found == next.end() || outline.size() > next.size()) return {};
    at = found->second;
  } while (at != first);
  if (outline.size() != next.size()) return {};
  return outline;
}

Result<TriangleMesh> TriangulateOutline(std::span<const Eigen::Vector2d> outline_m,
                                        std::span<const Eigen::Vector2d> inner_m) {
  try {
    Polygon polygon;
    for (const Eigen::Vector2d& p : outline_m) {
      if (!p.allFinite()) return InvalidInput("ground outline: a point is not finite");
      polygon.push_back(Point(p.x(), p.y()));
    }
    if (polygon.size() < 3 || !polygon.is_simple()) {
      return InvalidInput("ground outline: " + std::to_string(outline_m.size()) +
                          " points that are no simple polygon");
    }
    for (const Eigen::Vector2d& p : inner_m) {
      if (!p.allFinite()) return InvalidInput("ground outline: an inner point is not finite");
    }
    return Triangulated(polygon, inner_m);
  } catch (const std::exception& e) {
    return Failed(std::string("ground outline: ") + e.what());
  }
}

void Describe(OptionsVisitor& visitor, GroundPolygonOptions& options) {
  visitor.Field("colour_step_m",
                options.colour_step_m,
                {0, 10},
                "m",
                "distance of the points that carry the floor's measured colours; 0 = plain floor");
}

}  // namespace deepslam::mesh
