#include "deepslam/shape/mesh_check.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/core/disjoint_sets.h"
#include "deepslam/scene/mesh_pieces.h"

namespace deepslam::shape {
namespace {

using Face = std::array<std::uint32_t, 3>;

struct HalfEdge {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  bool forward = false;  // runs from low to high
  std::uint32_t face = 0;
};

// For each vertex the lowest index of a vertex at the same position.
std::vector<std::uint32_t> WeldByPosition(const std::vector<Eigen::Vector3f>& vertices) {
  std::vector<std::uint32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    const Eigen::Vector3f& p = vertices[a];
    const Eigen::Vector3f& q = vertices[b];
    if (p.x() != q.x()) return p.x() < q.x();
    if (p.y() != q.y()) return p.y() < q.y();
    if (p.z() != q.z()) return p.z() < q.z();
    return a < b;
  };
  std::sort(order.begin(), order.end(), less);
  std::vector<std::uint32_t> weld(vertices.size());
  for (std::size_t n = 0; n < order.size(); ++n) {
    const bool same = n > 0 && vertices[order[n]] == vertices[order[n - 1]];
    weld[order[n]] = same ? weld[order[n - 1]] : order[n];
  }
  return weld;
}

std::string FindInvalid(const TriangleMesh& mesh) {
  if (mesh.empty()) return "no faces";
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!mesh.vertices[v].allFinite()) return "vertex " + std::to_string(v) + " is not finite";
  }
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const std::uint32_t v : mesh.faces[f]) {
      if (v >= mesh.vertices.size())
        return "face " + std::to_string(f) + " has an index out of range";
    }
  }
  return {};
}

std::vector<HalfEdge> SortedHalfEdges(const std::vector<Face>& faces) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (std::size_t n = 0; n < 3; ++n) {
      const std::uint32_t a = faces[f][n];
      const std::uint32_t b = faces[f][(n + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b, static_cast<std::uint32_t>(f)});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.forward, a.face) < std::tie(b.low, b.high, b.forward, b.face);
  });
  return edges;
}

void NoteFault(MeshCheck& check, const std::string& fault) {
  if (check.fault.empty()) check.fault = fault;
}

// Closed and oriented: the half edges come in pairs of opposite direction. Joins the corners of
// faces that lie side by side.
void CheckEdges(const std::vector<HalfEdge>& edges,
                const std::vector<Face>& faces,
                DisjointSets& corners,
                MeshCheck& check) {
  const auto corner_of = [&](std::uint32_t face, std::uint32_t vertex) {
    const Face& f = faces[face];
    return 3 * face + (f[0] == vertex ? 0U : f[1] == vertex ? 1U : 2U);
  };
  check.closed = true;
  check.oriented = true;
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin;
    while (end < edges.size() && edges[end].low == edges[begin].low &&
           edges[end].high == edges[begin].high) {
      ++end;
    }
    if (end - begin != 2) {
      check.closed = false;
      NoteFault(check,
                "edge " + std::to_string(edges[begin].low) + "-" +
                    std::to_string(edges[begin].high) + " has " + std::to_string(end - begin) +
                    " faces");
    } else if (edges[begin].forward == edges[begin + 1].forward) {
      check.oriented = false;
      NoteFault(check,
                "faces " + std::to_string(edges[begin].face) + " and " +
                    std::to_string(edges[begin + 1].face) + " disagree in orientation");
    }
    for (std::size_t n = begin + 1; n < end; ++n) {
      for (const std::uint32_t vertex : {edges[n].low, edges[n].high}) {
        corners.Join(corner_of(edges[n - 1].face, vertex), corner_of(edges[n].face, vertex));
      }
    }
    begin = end;
  }
}

// All corners at a vertex must be one fan.
bool OneFanPerVertex(const std::vector<Face>& faces,
                     std::size_t num_vertices,
                     DisjointSets& corners,
                     MeshCheck& check) {
  constexpr std::uint32_t kNone = 0xFFFFFFFFU;  // no fan met yet
  std::vector<std::uint32_t> fan(num_vertices, kNone);
  for (std::uint32_t corner = 0; corner < 3 * faces.size(); ++corner) {
    const std::uint32_t vertex = faces[corner / 3][corner % 3];
    const std::uint32_t root = corners.LeastOf(corner);
    if (fan[vertex] == kNone) fan[vertex] = root;
    if (fan[vertex] != root) {
      NoteFault(check, "vertex " + std::to_string(vertex) + " joins two fans of faces");
      return false;
    }
  }
  return true;
}

int CountComponents(const std::vector<Face>& faces, std::size_t num_vertices) {
  const std::vector<std::uint32_t> piece = PieceOfVertex(faces, num_vertices);
  std::vector<std::uint8_t> is_root(num_vertices, 0);
  for (const Face& face : faces) is_root[piece[face[0]]] = 1;
  return static_cast<int>(std::count(is_root.begin(), is_root.end(), 1));
}

double SignedVolume(const TriangleMesh& mesh) {
  const Eigen::Vector3d origin = mesh.vertices[mesh.faces[0][0]].cast<double>();
  double six_volumes = 0;
  for (const Face& face : mesh.faces) {
    const Eigen::Vector3d a = mesh.vertices[face[0]].cast<double>() - origin;
    const Eigen::Vector3d b = mesh.vertices[face[1]].cast<double>() - origin;
    const Eigen::Vector3d c = mesh.vertices[face[2]].cast<double>() - origin;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6.0;
}

}  // namespace

MeshCheck CheckMesh(const TriangleMesh& mesh) {
  MeshCheck check;
  check.fault = FindInvalid(mesh);
  if (!check.fault.empty()) return check;
  const std::vector<std::uint32_t> weld = WeldByPosition(mesh.vertices);
  std::vector<Face> faces;
  faces.reserve(mesh.faces.size());
  check.valid = true;
  for (const Face& face : mesh.faces) {
    const Face welded = {weld[face[0]], weld[face[1]], weld[face[2]]};
    if (welded[0] == welded[1] || welded[1] == welded[2] || welded[2] == welded[0]) {
      check.valid = false;
      NoteFault(check, "face " + std::to_string(faces.size()) + " has two corners at one place");
      return check;
    }
    faces.push_back(welded);
  }
  DisjointSets corners(3 * faces.size());
  CheckEdges(SortedHalfEdges(faces), faces, corners, check);
  const bool fans = OneFanPerVertex(faces, mesh.vertices.size(), corners, check);
  check.num_components = CountComponents(faces, mesh.vertices.size());
  check.volume_m3 = SignedVolume(mesh);
  check.two_manifold = check.closed && fans;
  if (check.closed && check.oriented && check.volume_m3 <= 0) {
    check.oriented = false;
    NoteFault(check, "faces point inwards");
  }
  return check;
}

}  // namespace deepslam::shape
