#include "deepslam/mesh/extract_surface.h"

#include <CGAL/boost/graph/helpers.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Surface_mesh.h>

#include <array>
#include <cstddef>
#include <exception>
#include <vector>

#include "deepslam/mesh/check_mesh.h"
#include "deepslam/mesh/relax_boundary.h"
#include "deepslam/mesh/voxel_boundary.h"

namespace deepslam::mesh {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

// Halvings of the permitted shift before the bare voxel boundary, which cannot pierce itself, is
// taken.
constexpr int kExtractAttempts = 3;

Eigen::Vector3f ToObjectUnits(const Eigen::Vector3d& p_voxels) {
  return ((p_voxels.array() * kVoxelSize) - 0.5).matrix().cast<float>();
}

// Quads become triangles along the diagonal that CGAL prefers for their shape.
Result<SurfaceMesh> Triangulated(const std::vector<Eigen::Vector3d>& points,
                                 const VoxelBoundary& boundary) {
  std::vector<Kernel::Point_3> soup_points;
  soup_points.reserve(points.size());
  for (const Eigen::Vector3d& p : points) {
    // The coordinates that leave this function are floats: decide about those.
    const Eigen::Vector3f rounded = ToObjectUnits(p);
    soup_points.emplace_back(rounded.x(), rounded.y(), rounded.z());
  }
  std::vector<std::array<std::size_t, 4>> soup_quads;
  soup_quads.reserve(boundary.quads.size());
  for (const auto& quad : boundary.quads)
    soup_quads.push_back({quad[0], quad[1], quad[2], quad[3]});
  if (!pmp::is_polygon_soup_a_polygon_mesh(soup_quads)) {
    return Failed("voxel boundary is not a manifold");
  }
  SurfaceMesh mesh;
  pmp::polygon_soup_to_polygon_mesh(soup_points, soup_quads, mesh);
  if (!pmp::triangulate_faces(mesh)) return Failed("voxel boundary could not be triangulated");
  return mesh;
}

TriangleMesh ToTriangleMesh(const SurfaceMesh& mesh) {
  TriangleMesh result;
  result.vertices.reserve(mesh.number_of_vertices());
  for (const auto v : mesh.vertices()) {
    const Kernel::Point_3& p = mesh.point(v);
    result.vertices.emplace_back(
        static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  }
  result.faces.reserve(mesh.number_of_faces());
  for (const auto f : mesh.faces()) {
    std::array<std::uint32_t, 3> face{};
    std::size_t n = 0;
    for (const auto v : CGAL::vertices_around_face(mesh.halfedge(f), mesh)) {
      face[n++] = static_cast<std::uint32_t>(v.idx());
    }
    result.faces.push_back(face);
  }
  return result;
}

Result<TriangleMesh> RelaxUntilClean(const VoxelBoundary& boundary, const SurfaceOptions& options) {
  double shift = SurfaceOptions::kMaxShiftVoxels;
  for (int attempt = 0; attempt <= kExtractAttempts; ++attempt, shift *= 0.5) {
    const bool last = attempt == kExtractAttempts;
    const std::vector<Eigen::Vector3d> points =
        last ? boundary.vertices : RelaxBoundary(boundary, options.iterations, shift);
    const Result<SurfaceMesh> mesh = Triangulated(points, boundary);
    if (!mesh) return mesh.error();
    if (!CGAL::is_closed(*mesh)) return Failed("voxel boundary is not closed");
    if (last || !pmp::does_self_intersect(*mesh)) return ToTriangleMesh(*mesh);
  }
  return Failed("unreachable");
}

}  // namespace

Result<TriangleMesh> ExtractSurface(const VoxelGrid& grid, const SurfaceOptions& options) {
  const Result<VoxelBoundary> boundary = ExtractVoxelBoundary(grid, options.min_component_share);
  if (!boundary) return boundary.error();
  try {
    return RelaxUntilClean(*boundary, options);
  } catch (const std::exception& e) {
    return Failed(std::string("surface extraction: ") + e.what());
  }
}

bool SelfIntersects(const TriangleMesh& mesh) {
  std::vector<Kernel::Point_3> points;
  points.reserve(mesh.vertices.size());
  for (const Eigen::Vector3f& p : mesh.vertices) points.emplace_back(p.x(), p.y(), p.z());
  std::vector<std::array<std::size_t, 3>> faces;
  faces.reserve(mesh.faces.size());
  for (const auto& face : mesh.faces) faces.push_back({face[0], face[1], face[2]});
  if (!pmp::is_polygon_soup_a_polygon_mesh(faces)) return true;
  SurfaceMesh surface;
  pmp::polygon_soup_to_polygon_mesh(points, faces, surface);
  return pmp::does_self_intersect(surface);
}

void Describe(OptionsVisitor& visitor, SurfaceOptions& options) {
  visitor.Field("iterations",
                options.iterations,
                {0, 1000},
                "1",
                "relaxation steps of the surface; 0 = bare voxel boundary");
}

}  // namespace deepslam::mesh
