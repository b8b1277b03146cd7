#include "deepslam/mesh/refine_mesh.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModBaseT.hh>
#include <OpenMesh/Tools/Smoother/JacobiLaplaceSmootherT.hh>

// Not before the mesh kernel: it does not compile alone.
#include <OpenMesh/Core/Geometry/QuadricT.hh>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "deepslam/core/angles.h"
#include "deepslam/core/parallel.h"
#include "deepslam/mesh/check_mesh.h"
#include "deepslam/mesh/surface_distance.h"

namespace deepslam::mesh {
namespace {

struct Traits : public OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};

// With the test of a collapse in place of OpenMesh's own, which gives the same answers: as packaged
// that has assertions that compare names of types at every vertex it looks at, most of the time of
// decimation.
class Mesh : public OpenMesh::TriMesh_ArrayKernelT<Traits> {
 public:
  // Whether the surface stays a manifold when an edge is drawn together: its ends have no
  // neighbours in common but those across its two faces (the link condition of Dey et al. 1999).
  [[nodiscard]] bool is_collapse_ok(HalfedgeHandle v0v1) {
    const HalfedgeHandle v1v0 = opposite_halfedge_handle(v0v1);
    const VertexHandle v0 = to_vertex_handle(v1v0);
    const VertexHandle v1 = to_vertex_handle(v0v1);
    if (status(edge_handle(v0v1)).deleted() || status(v0).deleted() || status(v1).deleted())
      return false;
    const VertexHandle left = Across(v0v1);
    const VertexHandle right = Across(v1v0);
    if (left == right || IsLastAtRim(v0v1) || IsLastAtRim(v1v0)) return false;
    NeighboursOf(v0, neighbours_);
    const HalfedgeHandle first = halfedge_handle(v1);
    HalfedgeHandle out = first;
    do {
      const VertexHandle v = to_vertex_handle(out);
      if (v != left && v != right && v != v0 && IsIn(neighbours_, v)) return false;
      out = next_halfedge_handle(opposite_halfedge_handle(out));
    } while (out != first);
    const bool is_at_rim = is_boundary(v0v1) || is_boundary(v1v0);
    return is_at_rim || !is_boundary(v0) || !is_boundary(v1);
  }

 private:
  // The third corner of a halfedge's face; none at the rim.
  [[nodiscard]] VertexHandle Across(HalfedgeHandle edge) const {
    return is_boundary(edge) ? VertexHandle() : to_vertex_handle(next_halfedge_handle(edge));
  }
  // Whether a halfedge's face has its two other edges at the rim.
  [[nodiscard]] bool IsLastAtRim(HalfedgeHandle edge) const {
    if (is_boundary(edge)) return false;
    const HalfedgeHandle next = next_halfedge_handle(edge);
    return is_boundary(opposite_halfedge_handle(next)) &&
           is_boundary(opposite_halfedge_handle(next_halfedge_handle(next)));
  }
  void NeighboursOf(VertexHandle v, std::vector<VertexHandle>& neighbours) const {
    neighbours.clear();
    const HalfedgeHandle first = halfedge_handle(v);
    HalfedgeHandle out = first;
    do {
      neighbours.push_back(to_vertex_handle(out));
      out = next_halfedge_handle(opposite_halfedge_handle(out));
    } while (out != first);
  }
  [[nodiscard]] static bool IsIn(const std::vector<VertexHandle>& vertices, VertexHandle v) {
    return std::find(vertices.begin(), vertices.end(), v) != vertices.end();
  }

  std::vector<VertexHandle> neighbours_;  // kept for its memory
};
using Decimater = OpenMesh::Decimater::DecimaterT<Mesh>;

// A collapse may not turn a face by more than this, deg.
constexpr double kMaxNormalTurnDeg = 60.0;
constexpr int kRefineAttempts = 4;  // each with half the bound of the last
// Shares of the bound: smoothing keeps to its share exactly, decimation bounds a mean, of which the
// maximum is a multiple. On furniture these keep to the bound at the first attempt.
constexpr double kSmoothingShare = 0.3;
constexpr double kDecimationShare = 0.2;  // of the bound, as above

// Welded by position first: OpenMesh takes indices as they are.
std::optional<Mesh> ToOpenMesh(const TriangleMesh& source) {
  Mesh mesh;
  std::vector<Mesh::VertexHandle> handles;
  handles.reserve(source.vertices.size());
  for (const Eigen::Vector3f& p : source.vertices) {
    handles.push_back(mesh.add_vertex(Mesh::Point(p.x(), p.y(), p.z())));
  }
  for (const auto& face : source.faces) {
    if (!mesh.add_face(handles[face[0]], handles[face[1]], handles[face[2]]).is_valid()) {
      return std::nullopt;
    }
  }
  return mesh;
}

TriangleMesh ToTriangleMesh(const Mesh& mesh) {
  TriangleMesh result;
  result.vertices.reserve(mesh.n_vertices());
  for (const auto v : mesh.vertices()) {
    const Mesh::Point& p = mesh.point(v);
    result.vertices.emplace_back(
        static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]));
  }
  result.faces.reserve(mesh.n_faces());
  for (const auto f : mesh.faces()) {
    std::array<std::uint32_t, 3> face{};
    std::size_t n = 0;
    for (auto v = mesh.cfv_ccwbegin(f); v != mesh.cfv_ccwend(f); ++v) {
      face[n++] = static_cast<std::uint32_t>(v->idx());
    }
    result.faces.push_back(face);
  }
  return result;
}

void Smooth(Mesh& mesh, int iterations, double max_error) {
  if (iterations <= 0) return;
  using Smoother = OpenMesh::Smoother::JacobiLaplaceSmootherT<Mesh>;
  Smoother smoother(mesh);
  smoother.initialize(Smoother::Tangential_and_Normal, Smoother::C1);
  smoother.set_absolute_local_error(static_cast<Mesh::Normal::value_type>(max_error));
  smoother.smooth(static_cast<unsigned int>(iterations));
}

// Error quadrics (Garland and Heckbert 1997) with the area they stand for, so that a collapse can
// be refused by the root mean square distance from the planes it replaces. OpenMesh's own quadrics
// bound an error of no unit, and its Hausdorff module takes minutes on large flat faces. Nor may a
// collapse make long edges or turn faces (OpenMesh's ModNormalFlipping), which costs most to find
// out and is asked last.
template <class MeshT>
class ModPlaneDistance : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(ModPlaneDistance, MeshT, PlaneDistance)

  explicit ModPlaneDistance(MeshT& mesh) : Base(mesh, false) {}

  void set_max_distance(double distance) { max_squared_ = distance * distance; }
  void set_max_edge(double length) { max_edge_squared_ = length * length; }
  void set_max_normal_turn(double angle_rad) { min_cos_ = std::cos(angle_rad); }

  void initialize() override {
    quadrics_.assign(Base::mesh().n_vertices(), OpenMesh::Geometry::QuadricT<double>());
    areas_.assign(Base::mesh().n_vertices(), 0.0);
    for (const auto face : Base::mesh().faces()) {
      auto corner = Base::mesh().cfv_ccwbegin(face);
      const std::array<OpenMesh::VertexHandle, 3> v = {*corner++, *corner++, *corner};
      const auto a = Base::mesh().point(v[0]);
      auto normal = (Base::mesh().point(v[1]) - a) % (Base::mesh().point(v[2]) - a);
      const double length = normal.norm();
      if (length <= 0) continue;
      normal /= length;
      OpenMesh::Geometry::QuadricT<double> quadric(normal[0], normal[1], normal[2], -(a | normal));
      quadric *= 0.5 * length;
      for (const auto vertex : v) {
        quadrics_[static_cast<std::size_t>(vertex.idx())] += quadric;
        areas_[static_cast<std::size_t>(vertex.idx())] += 0.5 * length;
      }
    }
  }

  float collapse_priority(const CollapseInfo& info) override {
    const auto removed = static_cast<std::size_t>(info.v0.idx());
    const auto kept = static_cast<std::size_t>(info.v1.idx());
    auto quadric = quadrics_[removed];
    quadric += quadrics_[kept];
    const double error = std::max(0.0, quadric(info.p1));
    if (error > max_squared_ * (areas_[removed] + areas_[kept])) {
      return static_cast<float>(Base::ILLEGAL_COLLAPSE);
    }
    const auto priority = static_cast<float>(error);
    if (info.v0 != asked_) best_of_asked_ = std::numeric_limits<float>::max();
    asked_ = info.v0;
    if (!(priority < best_of_asked_) || MakesLongEdge(info) || TurnsFace(info))
      return static_cast<float>(Base::ILLEGAL_COLLAPSE);
    return best_of_asked_ = priority;
  }

  void postprocess_collapse(const CollapseInfo& info) override {
    const auto removed = static_cast<std::size_t>(info.v0.idx());
    const auto kept = static_cast<std::size_t>(info.v1.idx());
    quadrics_[kept] += quadrics_[removed];
    areas_[kept] += areas_[removed];
    asked_ = OpenMesh::VertexHandle();
  }

 private:
  bool MakesLongEdge(const CollapseInfo& info) {
    for (auto v = Base::mesh().cvv_iter(info.v0); v.is_valid(); ++v) {
      if ((Base::mesh().point(*v) - info.p1).sqrnorm() > max_edge_squared_) return true;
    }
    return false;
  }

  bool TurnsFace(const CollapseInfo& info) {
    auto& mesh = Base::mesh();
    mesh.set_point(info.v0, info.p1);
    bool is_turned = false;
    for (auto face = mesh.cvf_iter(info.v0); face.is_valid() && !is_turned; ++face) {
      if (*face == info.fl || *face == info.fr) continue;
      is_turned = (mesh.normal(*face) | mesh.calc_face_normal(*face)) < min_cos_;
    }
    mesh.set_point(info.v0, info.p0);
    return is_turned;
  }

  double max_squared_ = 0;
  double max_edge_squared_ = 0;
  double min_cos_ = 0;
  // The decimater asks for all edges of a vertex and takes the best: a worse one need not be legal.
  OpenMesh::VertexHandle asked_;
  float best_of_asked_ = 0;
  std::vector<OpenMesh::Geometry::QuadricT<double>> quadrics_;
  std::vector<double> areas_;
};

void Decimate(Mesh& mesh, double max_distance, const RefineOptions& options) {
  Decimater decimater(mesh);
  ModPlaneDistance<Mesh>::Handle distance;
  decimater.add(distance);
  decimater.module(distance).set_max_distance(max_distance);
  decimater.module(distance).set_max_edge(options.max_edge);
  decimater.module(distance).set_max_normal_turn(kMaxNormalTurnDeg * kRadPerDeg);
  if (!decimater.initialize()) return;
  decimater.decimate_to_faces(0, static_cast<std::size_t>(options.target_faces));
  mesh.garbage_collection();
}

// Whether a refined mesh keeps to the bound and does not pierce itself, asked side by side: what is
// largest is often refined last, by itself.
bool KeepsShape(const TriangleMesh& source, const TriangleMesh& refined, double max_error) {
  std::array<std::uint8_t, 2> holds{};
  ParallelFor(holds.size(), [&](std::size_t n) {
    holds[n] =
        (n == 0 ? WithinDistance(source, refined, max_error) : !SelfIntersects(refined)) ? 1 : 0;
  });
  return holds[0] != 0 && holds[1] != 0;
}

}  // namespace

Result<TriangleMesh> RefineMesh(const TriangleMesh& source, const RefineOptions& options) {
  const MeshCheck before = CheckMesh(source);
  if (!before.ok()) return InvalidInput("mesh to refine: " + before.fault);
  double bound = options.max_error;
  for (int attempt = 0; attempt < kRefineAttempts; ++attempt, bound *= 0.5) {
    std::optional<Mesh> mesh = ToOpenMesh(source);
    if (!mesh) return InvalidInput("mesh to refine: vertices at one place must be one vertex");
    mesh->request_face_status();
    mesh->request_edge_status();
    mesh->request_vertex_status();
    mesh->request_face_normals();
    mesh->request_vertex_normals();
    mesh->update_normals();
    Smooth(*mesh, RefineOptions::kSmoothingIterations, kSmoothingShare * bound);
    mesh->update_normals();
    Decimate(*mesh, kDecimationShare * bound, options);
    const TriangleMesh refined = ToTriangleMesh(*mesh);
    const MeshCheck after = CheckMesh(refined);
    if (after.ok() && after.num_components == before.num_components &&
        KeepsShape(source, refined, options.max_error)) {
      return refined;
    }
  }
  TriangleMesh unchanged = source;
  unchanged.colours.clear();
  return unchanged;
}

void Describe(OptionsVisitor& visitor, RefineOptions& options) {
  visitor.Field("max_edge",
                options.max_edge,
                {1e-6, 1e6},
                "1",
                "longest edge that decimation makes, object units; shorter = finer colours");
  visitor.Field("target_faces",
                options.target_faces,
                {4, 1'000'000},
                "1",
                "decimation stops at this number of faces, or earlier at the bounds");
}

}  // namespace deepslam::mesh
