#include "deepslam/mesh/refine_mesh.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModHausdorffT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <OpenMesh/Tools/Smoother/JacobiLaplaceSmootherT.hh>

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "deepslam/mesh/check_mesh.h"

namespace deepslam::mesh {
namespace {

struct Traits : public OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Mesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using Decimater = OpenMesh::Decimater::DecimaterT<Mesh>;

// A collapse may not turn a face by more than this, deg.
constexpr double kMaxNormalTurnDeg = 60.0;
constexpr int kMaxAttempts = 3;

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

void Decimate(Mesh& mesh, double max_error, int target_faces) {
  Decimater decimater(mesh);
  OpenMesh::Decimater::ModQuadricT<Mesh>::Handle quadric;
  OpenMesh::Decimater::ModHausdorffT<Mesh>::Handle hausdorff;
  OpenMesh::Decimater::ModNormalFlippingT<Mesh>::Handle flipping;
  decimater.add(quadric);
  decimater.add(hausdorff);
  decimater.add(flipping);
  decimater.module(quadric).unset_max_err();
  decimater.module(hausdorff).set_tolerance(max_error);
  decimater.module(flipping).set_max_normal_deviation(kMaxNormalTurnDeg);
  if (!decimater.initialize()) return;
  decimater.decimate_to_faces(0, static_cast<std::size_t>(target_faces));
  mesh.garbage_collection();
}

}  // namespace

Result<TriangleMesh> RefineMesh(const TriangleMesh& source, const RefineOptions& options) {
  const MeshCheck before = CheckMesh(source);
  if (!before.ok()) return InvalidInput("mesh to refine: " + before.fault);
  double bound = 0.5 * options.max_error;
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt, bound *= 0.5) {
    std::optional<Mesh> mesh = ToOpenMesh(source);
    if (!mesh) return InvalidInput("mesh to refine: vertices at one place must be one vertex");
    mesh->request_face_status();
    mesh->request_edge_status();
    mesh->request_vertex_status();
    mesh->request_face_normals();
    mesh->request_vertex_normals();
    mesh->update_normals();
    Smooth(*mesh, options.smoothing_iterations, bound);
    mesh->update_normals();
    Decimate(*mesh, bound, options.target_faces);
    const TriangleMesh refined = ToTriangleMesh(*mesh);
    const MeshCheck after = CheckMesh(refined);
    if (after.ok() && after.num_components == before.num_components && !SelfIntersects(refined)) {
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
  visitor.Field("target_faces",
                options.target_faces,
                {4, 1'000'000},
                "1",
                "decimation stops at this number of faces, or earlier at the bound");
}

}  // namespace deepslam::mesh
