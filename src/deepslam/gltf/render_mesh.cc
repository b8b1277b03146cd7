#include "deepslam/gltf/render_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "deepslam/core/disjoint_sets.h"

namespace deepslam::gltf {
namespace {

using Face = std::array<std::uint32_t, 3>;

std::array<float, 3> Key(const Eigen::Vector3f& p) {
  // + 0 makes -0 and 0 one place.
  return {p.x() + 0.0F, p.y() + 0.0F, p.z() + 0.0F};
}

// Vertex indices with those at one place replaced by the first of them, and only faces with three
// places.
std::vector<Face> WeldedFaces(const TriangleMesh& mesh) {
  using Placed = std::pair<std::array<float, 3>, std::uint32_t>;
  std::vector<Placed> order;
  order.reserve(mesh.vertices.size());
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
    order.emplace_back(Key(mesh.vertices[v]), v);
  if (!std::is_sorted(order.begin(), order.end())) std::sort(order.begin(), order.end());
  std::vector<std::uint32_t> weld(mesh.vertices.size());
  for (std::size_t n = 0; n < order.size(); ++n) {
    const bool same = n > 0 && order[n].first == order[n - 1].first;
    weld[order[n].second] = same ? weld[order[n - 1].second] : order[n].second;
  }
  std::vector<Face> faces;
  faces.reserve(mesh.faces.size());
  for (const Face& face : mesh.faces) {
    const Face f = {weld[face[0]], weld[face[1]], weld[face[2]]};
    if (f[0] != f[1] && f[1] != f[2] && f[2] != f[0]) faces.push_back(f);
  }
  return faces;
}

// Twice the area times the unit normal, in glTF's axes.
std::vector<Eigen::Vector3d> FaceNormals(const TriangleMesh& mesh, const std::vector<Face>& faces) {
  std::vector<Eigen::Vector3d> normals;
  normals.reserve(faces.size());
  for (const Face& face : faces) {
    const Eigen::Vector3d a = ToGltfAxes(mesh.vertices[face[0]].cast<double>().eval());
    const Eigen::Vector3d b = ToGltfAxes(mesh.vertices[face[1]].cast<double>().eval());
    const Eigen::Vector3d c = ToGltfAxes(mesh.vertices[face[2]].cast<double>().eval());
    normals.push_back((b - a).cross(c - a));
  }
  return normals;
}

// Side of a face, between the corners (3 * face + n) at its vertices.
struct Side {
  std::uint32_t low, high, corner_low, corner_high;
};

// By vertices, then by corners.
std::vector<Side> SortedSides(const std::vector<Face>& faces, std::size_t num_vertices) {
  std::vector<Side> sides;
  sides.reserve(3 * faces.size());
  std::vector<std::size_t> next(num_vertices + 1, 0);  // place of the next side of a low vertex
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    for (std::uint32_t n = 0; n < 3; ++n) {
      const std::uint32_t m = (n + 1) % 3;
      Side side{faces[f][n], faces[f][m], 3 * f + n, 3 * f + m};
      if (side.low > side.high) side = {side.high, side.low, side.corner_high, side.corner_low};
      sides.push_back(side);
      ++next[side.low + 1];
    }
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<Side> sorted(sides.size());
  for (const Side& side : sides) sorted[next[side.low]++] = side;
  std::size_t begin = 0;
  for (std::size_t v = 0; v < num_vertices; ++v) {  // next[v] is where the sides of v end now
    std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(begin),
              sorted.begin() + static_cast<std::ptrdiff_t>(next[v]),
              [](const Side& a, const Side& b) {
                return std::tie(a.high, a.corner_low) < std::tie(b.high, b.corner_low);
              });
    begin = next[v];
  }
  return sorted;
}

// Corners that share a vertex and a smooth edge are one: returns each corner's representative.
std::vector<std::uint32_t> SmoothCorners(const std::vector<Face>& faces,
                                         std::size_t num_vertices,
                                         const std::vector<Eigen::Vector3d>& normals,
                                         double crease_angle_rad) {
  const std::vector<Side> sides = SortedSides(faces, num_vertices);
  DisjointSets smooth(3 * faces.size());
  const double min_cosine = std::cos(crease_angle_rad);
  for (std::size_t n = 1; n < sides.size(); ++n) {
    const Side& a = sides[n - 1];
    const Side& b = sides[n];
    if (a.low != b.low || a.high != b.high) continue;
    const Eigen::Vector3d& na = normals[a.corner_low / 3];
    const Eigen::Vector3d& nb = normals[b.corner_low / 3];
    if (na.dot(nb) < min_cosine * na.norm() * nb.norm()) continue;
    smooth.Join(a.corner_low, b.corner_low);
    smooth.Join(a.corner_high, b.corner_high);
  }
  return smooth.LeastOfEach();
}

}  // namespace

std::uint16_t LinearFromSrgb(std::uint8_t value) {
  const double s = value / 255.0;
  const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  return static_cast<std::uint16_t>(std::lround(linear * 65535.0));
}

RenderMesh MakeRenderMesh(const TriangleMesh& mesh, double crease_angle_rad) {
  const std::vector<Face> faces = WeldedFaces(mesh);
  const std::vector<Eigen::Vector3d> face_normals = FaceNormals(mesh, faces);
  const std::vector<std::uint32_t> corner =
      SmoothCorners(faces, mesh.vertices.size(), face_normals, crease_angle_rad);
  std::array<std::uint16_t, 256> linear{};
  for (std::size_t c = 0; c < linear.size(); ++c)
    linear[c] = LinearFromSrgb(static_cast<std::uint8_t>(c));
  constexpr std::uint32_t kNone = 0xFFFFFFFFU;  // the corner has no vertex yet
  std::vector<std::uint32_t> id(corner.size(), kNone);
  std::vector<Eigen::Vector3d> normals;
  RenderMesh result;
  result.faces.reserve(faces.size());
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    Face face{};
    for (std::uint32_t n = 0; n < 3; ++n) {
      const std::uint32_t vertex = faces[f][n];
      std::uint32_t& own = id[corner[3 * f + n]];
      if (own == kNone) {
        own = static_cast<std::uint32_t>(result.positions.size());
        const auto place = Key(mesh.vertices[vertex]);
        result.positions.push_back(ToGltfAxes(Eigen::Vector3f(place[0], place[1], place[2])));
        normals.emplace_back(Eigen::Vector3d::Zero());
        if (!mesh.colours.empty()) {
          const Rgb8 c = mesh.colours[vertex];
          result.colours.push_back({linear[c.r], linear[c.g], linear[c.b], 65535});
        }
      }
      face[n] = own;
      normals[own] += face_normals[f];
    }
    result.faces.push_back(face);
  }
  for (const Eigen::Vector3d& sum : normals) {
    const double length = sum.norm();
    const Eigen::Vector3d unit = length > 0 ? (sum / length).eval() : Eigen::Vector3d::UnitY();
    result.normals.push_back(unit.cast<float>());
  }
  return result;
}

}  // namespace deepslam::gltf
