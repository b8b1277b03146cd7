#include "deepslam/fuse/canonical_mesh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>

#include "deepslam/scene/mesh_pieces.h"

namespace deepslam::fuse {

TriangleMesh CanonicalMesh(const TriangleMesh& mesh) {
  std::vector<std::uint8_t> used(mesh.vertices.size(), 0);
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t v : face) used[v] = 1;
  }
  const bool coloured = !mesh.colours.empty();
  const auto key = [&](std::uint32_t v) {
    const Eigen::Vector3f& p = mesh.vertices[v];
    const Rgb8 c = coloured ? mesh.colours[v] : Rgb8{};
    return std::tuple(p.x(), p.y(), p.z(), c.r, c.g, c.b);
  };
  std::vector<std::uint32_t> order;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (used[v] != 0) order.push_back(v);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return key(a) < key(b);
  });
  TriangleMesh result;
  std::vector<std::uint32_t> place(mesh.vertices.size(), 0);
  for (const std::uint32_t v : order) {
    // Vertices alike in everything become one: their order could not be told from the mesh.
    const bool same = !result.vertices.empty() && result.vertices.back() == mesh.vertices[v] &&
                      (!coloured || result.colours.back() == mesh.colours[v]);
    if (!same) {
      result.vertices.push_back(mesh.vertices[v]);
      if (coloured) result.colours.push_back(mesh.colours[v]);
    }
    place[v] = static_cast<std::uint32_t>(result.vertices.size()) - 1;
  }
  for (const auto& face : mesh.faces) {
    std::array<std::uint32_t, 3> f = {place[face[0]], place[face[1]], place[face[2]]};
    if (f[0] == f[1] || f[1] == f[2] || f[2] == f[0]) continue;
    std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
    result.faces.push_back(f);
  }
  std::sort(result.faces.begin(), result.faces.end());
  result.faces.erase(std::unique(result.faces.begin(), result.faces.end()), result.faces.end());
  return result;
}

TriangleMesh WithoutSmallComponents(const TriangleMesh& mesh, int min_faces) {
  const std::vector<std::uint32_t> piece = PieceOfVertex(mesh.faces, mesh.vertices.size());
  std::vector<int> sizes(mesh.vertices.size(), 0);
  for (const auto& face : mesh.faces) ++sizes[piece[face[0]]];
  TriangleMesh result;
  result.vertices = mesh.vertices;
  result.colours = mesh.colours;
  for (const auto& face : mesh.faces) {
    if (sizes[piece[face[0]]] >= min_faces) result.faces.push_back(face);
  }
  return result;
}

}  // namespace deepslam::fuse
