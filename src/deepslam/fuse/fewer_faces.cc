#include "deepslam/fuse/fewer_faces.h"

#include <meshoptimizer.h>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace deepslam::fuse {
namespace {

using Indices = std::vector<std::array<std::uint32_t, 3>>;

// `simplify(to, from, num_from, positions, num_vertices, stride)` gives the number of indices.
template <typename Simplify>
Indices Simplified(const TriangleMesh& mesh, const Indices& faces, const Simplify& simplify) {
  static_assert(sizeof(faces[0]) == 3 * sizeof(unsigned int) && sizeof(mesh.vertices[0]) == 12);
  Indices fewer(faces.size());
  const std::size_t num_indices = simplify(fewer.data()->data(),
                                           faces.data()->data(),
                                           3 * faces.size(),
                                           mesh.vertices.data()->data(),
                                           mesh.vertices.size(),
                                           sizeof(mesh.vertices[0]));
  fewer.resize(num_indices / 3);
  return fewer;
}

}  // namespace

TriangleMesh WithFewerFaces(TriangleMesh mesh, std::size_t max_faces) {
  if (mesh.faces.size() <= max_faces) return mesh;
  constexpr float kAnyError = std::numeric_limits<float>::max();
  mesh.faces = Simplified(mesh, mesh.faces, [&](auto* to, auto... from) {
    return meshopt_simplify(to, from..., 3 * max_faces, kAnyError, 0, nullptr);
  });
  // Topology can forbid to go as far; clusters of vertices do not ask for it.
  if (mesh.faces.size() > max_faces) {
    mesh.faces = Simplified(mesh, mesh.faces, [&](auto* to, auto... from) {
      return meshopt_simplifySloppy(to, from..., 3 * max_faces, kAnyError, nullptr);
    });
  }
  return mesh;
}

}  // namespace deepslam::fuse
