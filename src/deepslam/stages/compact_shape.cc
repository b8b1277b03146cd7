#include "deepslam/stages/compact_shape.h"

#include <array>
#include <cmath>
#include <utility>

#include "deepslam/gltf/draco_mesh.h"
#include "deepslam/mesh/check_mesh.h"
#include "deepslam/mesh/refine_mesh.h"
#include "deepslam/mesh/surface_distance.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::stages {
namespace {

// Shares of the bound that decimation may use, the first that leaves enough to a grid is taken.
constexpr std::array<double, 3> kDecimationShares = {1.0, 0.7, 0.4};
constexpr int kMaxBits = 14;

// What the encodings of one shape are held against.
struct Wanted {
  const TriangleMesh& source;
  int num_components = 0;
  double max_error_m = 0;
};

// Bytes on a grid of so many bits; none when the surface they give is not good enough.
std::string Encoded(const TriangleMesh& mesh, int bits, const Wanted& wanted) {
  Result<std::string> bytes = gltf::DracoEncode(mesh, bits);
  if (!bytes.ok()) return {};
  const Result<TriangleMesh> decoded = gltf::DracoDecode(*bytes);
  if (!decoded.ok()) return {};
  const mesh::MeshCheck check = mesh::CheckMesh(*decoded);
  const bool good = check.ok() && check.num_components == wanted.num_components &&
                    mesh::SurfaceDistance(wanted.source, *decoded) <= wanted.max_error_m &&
                    !mesh::SelfIntersects(*decoded);
  return good ? std::move(bytes).value() : std::string();
}

// On the coarsest grid that is good enough, looked for from the one whose rounding fits into `left_m`
// in any case.
std::string CoarsestEncoding(const TriangleMesh& mesh, double left_m, const Wanted& wanted) {
  int safe_bits = gltf::kMinPositionBits;
  while (safe_bits < kMaxBits &&
         std::sqrt(3.0) * gltf::QuantisationError(mesh, safe_bits) > left_m) {
    ++safe_bits;
  }
  std::string best;
  for (int bits = safe_bits; bits >= gltf::kMinPositionBits; --bits) {
    std::string bytes = Encoded(mesh, bits, wanted);
    if (bytes.empty()) break;
    best = std::move(bytes);
  }
  for (int bits = safe_bits + 1; bits <= kMaxBits && best.empty(); ++bits)
    best = Encoded(mesh, bits, wanted);
  return best;
}

}  // namespace

Result<std::string> EncodeCompactShape(const TriangleMesh& mesh_object_m, double scale_m) {
  TriangleMesh source = mesh_object_m;
  source.colours.clear();
  const mesh::MeshCheck check = mesh::CheckMesh(source);
  if (!check.ok()) return InvalidInput("shape to embed: " + check.fault);
  const double max_error_m = kEmbeddedErrorVoxels * kVoxelSize * scale_m;
  for (const double share : kDecimationShares) {
    mesh::RefineOptions options;
    options.smoothing_iterations = 0;
    options.max_error = share * max_error_m;
    options.max_edge = 1e3;
    options.target_faces = 4;
    const Result<TriangleMesh> decimated = mesh::RefineMesh(source, options);
    if (!decimated.ok()) return decimated.error();
    const double left_m = max_error_m - mesh::SurfaceDistance(source, *decimated);
    std::string bytes =
        CoarsestEncoding(*decimated, left_m, {source, check.num_components, max_error_m});
    if (!bytes.empty()) return bytes;
  }
  return gltf::DracoEncode(source, kMaxBits);  // nothing coarser keeps to the bound
}

}  // namespace deepslam::stages
