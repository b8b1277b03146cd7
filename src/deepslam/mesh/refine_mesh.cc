#include "deepslam/mesh/refine_mesh.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Smoother/JacobiLaplaceSmootherT.hh>
#include <OpenMesh/Tools/Utils/HeapT.hh>

// Not before the mesh kernel: it does not compile alone.
#include <OpenMesh/Core/Geometry/QuadricT.hh>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/mesh/check_mesh.h"
#include "deepslam/mesh/surface_distance.h"

namespace deepslam::mesh {
namespace {

struct Traits : public OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};

using Mesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;

// A collapse may not turn a face by more than this, deg.
constexpr double kMaxNormalTurnDeg = 60.0;
constexpr int kMaxAttempts = 4;
// Shares of the bound: smoothing keeps to its share exactly, decimation bounds a mean, of which the
// maximum is a multiple. On furniture these keep to the bound at the first attempt.
constexpr double kSmoothingShare = 0.3;
constexpr double kDecimationShare = 0.2;

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

// Draws edges of a closed mesh together, that of least error first, by error quadrics (Garland and
// Heckbert 1997) with the area they stand for, so that a collapse can be refused by the root mean
// square distance from the planes it replaces: OpenMesh's own quadrics bound an error of no unit,
// and its Hausdorff module takes minutes on large flat faces. Nor may a collapse make long edges or
// turn faces. Order and answers are those of OpenMesh's decimater, which asks what is dear first.
class Decimation {
 public:
  Decimation(Mesh& mesh, double max_distance, double max_edge, double max_normal_turn_rad)
      : mesh_(mesh),
        max_squared_(max_distance * max_distance),
        max_edge_squared_(max_edge * max_edge),
        min_cos_(std::cos(max_normal_turn_rad)),
        quadrics_(mesh.n_vertices()),
        areas_(mesh.n_vertices(), 0.0),
        marks_(mesh.n_vertices(), 0),
        targets_(mesh.n_vertices()),
        queue_({std::vector<float>(mesh.n_vertices(), -1.0F),
                std::vector<int>(mesh.n_vertices(), -1)}) {
    for (const auto face : mesh_.faces()) AddPlane(face);
  }

  void Run(std::size_t target_faces) {
    if (target_faces >= mesh_.n_faces()) return;
    queue_.reserve(mesh_.n_vertices());
    for (const auto v : mesh_.vertices()) Enqueue(v);
    std::size_t num_faces = mesh_.n_faces();
    while (!queue_.empty() && target_faces < num_faces) {
      const VertexHandle removed = queue_.front();
      queue_.pop_front();
      const HalfedgeHandle edge = targets_[Index(removed)];
      MarkNeighbours(removed);  // they may have changed
      if (mesh_.status(mesh_.edge_handle(edge)).deleted() || !IsLegal(edge)) continue;
      Collapse(edge);
      num_faces -= 2;
    }
    mesh_.garbage_collection();
  }

 private:
  using VertexHandle = Mesh::VertexHandle;
  using HalfedgeHandle = Mesh::HalfedgeHandle;
  using Quadric = OpenMesh::Geometry::QuadricT<double>;

  // How the heap of vertices asks for their order and keeps their places.
  struct Order {
    std::vector<float> errors;
    std::vector<int> places;  // -1: not in the heap

    bool less(VertexHandle a, VertexHandle b) const { return errors[Index(a)] < errors[Index(b)]; }
    int get_heap_position(VertexHandle v) const { return places[Index(v)]; }
    void set_heap_position(VertexHandle v, int place) { places[Index(v)] = place; }
  };

  static std::size_t Index(VertexHandle v) { return static_cast<std::size_t>(v.idx()); }

  void AddPlane(Mesh::FaceHandle face) {
    auto corner = mesh_.cfv_ccwbegin(face);
    const std::array<VertexHandle, 3> v = {*corner++, *corner++, *corner};
    const auto a = mesh_.point(v[0]);
    auto normal = (mesh_.point(v[1]) - a) % (mesh_.point(v[2]) - a);
    const double length = normal.norm();
    if (length <= 0) return;
    normal /= length;
    Quadric quadric(normal[0], normal[1], normal[2], -(a | normal));
    quadric *= 0.5 * length;
    for (const VertexHandle vertex : v) {
      quadrics_[Index(vertex)] += quadric;
      areas_[Index(vertex)] += 0.5 * length;
    }
  }

  // The vertex stands in the queue by its best collapse; without any it leaves it.
  void Enqueue(VertexHandle v) {
    float best = std::numeric_limits<float>::max();
    HalfedgeHandle target;
    MarkNeighbours(v);
    for (auto edge = mesh_.cvoh_iter(v); edge.is_valid(); ++edge) {
      const std::optional<float> error = Error(v, mesh_.to_vertex_handle(*edge));
      if (!error || !(*error < best) || MakesLongEdge(*edge) || !IsLegal(*edge) ||
          TurnsFace(*edge)) {
        continue;
      }
      best = *error;
      target = *edge;
    }
    targets_[Index(v)] = target;
    if (!target.is_valid()) {
      if (queue_.is_stored(v)) queue_.remove(v);
      return;
    }
    queue_.getInterface().errors[Index(v)] = best;
    if (queue_.is_stored(v)) {
      queue_.update(v);
    } else {
      queue_.insert(v);
    }
  }

  // Of a collapse of one vertex into another; nothing beyond the bound.
  [[nodiscard]] std::optional<float> Error(VertexHandle removed, VertexHandle kept) const {
    Quadric quadric = quadrics_[Index(removed)];
    quadric += quadrics_[Index(kept)];
    const double error = std::max(0.0, quadric(mesh_.point(kept)));
    if (error > max_squared_ * (areas_[Index(removed)] + areas_[Index(kept)])) return std::nullopt;
    return static_cast<float>(error);
  }

  // Calls visit(halfedge) for all that leave the vertex until it gives false; whether none did.
  template <typename Visit>
  bool ForOutgoing(VertexHandle v, const Visit& visit) const {
    const HalfedgeHandle first = mesh_.halfedge_handle(v);
    HalfedgeHandle out = first;
    do {
      if (!visit(out)) return false;
      out = mesh_.next_halfedge_handle(mesh_.opposite_halfedge_handle(out));
    } while (out != first);
    return true;
  }

  void MarkNeighbours(VertexHandle v) {
    ++mark_;
    ForOutgoing(v, [&](HalfedgeHandle out) {
      marks_[Index(mesh_.to_vertex_handle(out))] = mark_;
      return true;
    });
  }

  [[nodiscard]] bool HasThreeNeighbours(VertexHandle v) const {
    int count = 0;
    return ForOutgoing(v, [&](HalfedgeHandle) { return ++count <= 3; }) && count == 3;
  }

  // Whether the surface stays a manifold when an edge of the vertex whose neighbours are marked is
  // drawn together: its ends have no neighbours in common but those across its two faces (the link
  // condition of Dey et al. 1999).
  [[nodiscard]] bool IsLegal(HalfedgeHandle edge) const {
    const HalfedgeHandle back = mesh_.opposite_halfedge_handle(edge);
    const VertexHandle left = mesh_.to_vertex_handle(mesh_.next_halfedge_handle(edge));
    const VertexHandle right = mesh_.to_vertex_handle(mesh_.next_halfedge_handle(back));
    if (left == right) return false;
    const bool is_free = ForOutgoing(mesh_.to_vertex_handle(edge), [&](HalfedgeHandle out) {
      const VertexHandle v = mesh_.to_vertex_handle(out);
      return v == left || v == right || marks_[Index(v)] != mark_;
    });
    if (!is_free) return false;
    return !HasThreeNeighbours(left) || !HasThreeNeighbours(right) ||
           !mesh_.find_halfedge(left, right).is_valid();
  }

  [[nodiscard]] bool MakesLongEdge(HalfedgeHandle edge) const {
    const Mesh::Point& kept = mesh_.point(mesh_.to_vertex_handle(edge));
    return !ForOutgoing(mesh_.from_vertex_handle(edge), [&](HalfedgeHandle out) {
      return (mesh_.point(mesh_.to_vertex_handle(out)) - kept).sqrnorm() <= max_edge_squared_;
    });
  }

  [[nodiscard]] bool TurnsFace(HalfedgeHandle edge) {
    const VertexHandle removed = mesh_.from_vertex_handle(edge);
    const Mesh::FaceHandle left = mesh_.face_handle(edge);
    const Mesh::FaceHandle right = mesh_.face_handle(mesh_.opposite_halfedge_handle(edge));
    const Mesh::Point before = mesh_.point(removed);
    mesh_.set_point(removed, mesh_.point(mesh_.to_vertex_handle(edge)));
    const bool stays = ForOutgoing(removed, [&](HalfedgeHandle out) {
      const Mesh::FaceHandle face = mesh_.face_handle(out);
      return face == left || face == right ||
             !((mesh_.normal(face) | mesh_.calc_face_normal(face)) < min_cos_);
    });
    mesh_.set_point(removed, before);
    return !stays;
  }

  void Collapse(HalfedgeHandle edge) {
    const VertexHandle removed = mesh_.from_vertex_handle(edge);
    const VertexHandle kept = mesh_.to_vertex_handle(edge);
    neighbours_.clear();
    for (auto v = mesh_.cvv_iter(removed); v.is_valid(); ++v) neighbours_.push_back(*v);
    mesh_.collapse(edge);
    for (auto face = mesh_.cvf_iter(kept); face.is_valid(); ++face)
      mesh_.set_normal(*face, mesh_.calc_face_normal(*face));
    quadrics_[Index(kept)] += quadrics_[Index(removed)];
    areas_[Index(kept)] += areas_[Index(removed)];
    for (const VertexHandle v : neighbours_) Enqueue(v);
  }

  Mesh& mesh_;
  double max_squared_ = 0;
  double max_edge_squared_ = 0;
  double min_cos_ = 0;
  std::vector<Quadric> quadrics_;
  std::vector<double> areas_;
  std::vector<std::uint64_t> marks_;  // mark_ at the neighbours of the vertex that is looked at
  std::uint64_t mark_ = 0;
  std::vector<HalfedgeHandle> targets_;
  std::vector<VertexHandle> neighbours_;  // kept for its memory
  OpenMesh::Utils::HeapT<VertexHandle, Order> queue_;
};

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
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt, bound *= 0.5) {
    std::optional<Mesh> mesh = ToOpenMesh(source);
    if (!mesh) return InvalidInput("mesh to refine: vertices at one place must be one vertex");
    mesh->request_face_status();
    mesh->request_edge_status();
    mesh->request_vertex_status();
    mesh->request_face_normals();
    mesh->request_vertex_normals();
    mesh->update_normals();
    Smooth(*mesh, options.smoothing_iterations, kSmoothingShare * bound);
    mesh->update_normals();
    Decimation(*mesh,
               kDecimationShare * bound,
               options.max_edge,
               kMaxNormalTurnDeg / 180.0 * std::numbers::pi)
        .Run(static_cast<std::size_t>(options.target_faces));
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
  visitor.Field("smoothing_iterations",
                options.smoothing_iterations,
                {0, 100},
                "1",
                "Jacobi-Laplace smoothing steps before decimation");
  visitor.Field("max_error",
                options.max_error,
                {1e-6, 1.0},
                "1",
                "Hausdorff bound against the extracted surface, object units (a voxel is 1/64)");
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
