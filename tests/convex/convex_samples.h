// Closed meshes with known volumes.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "deepslam/convex/convex_hull.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::testing_support {

inline TriangleMesh BoxMesh(const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
  std::vector<Eigen::Vector3f> corners;
  for (const float x : {low.x(), high.x()}) {
    for (const float y : {low.y(), high.y()}) {
      for (const float z : {low.z(), high.z()}) corners.emplace_back(x, y, z);
    }
  }
  return convex::ConvexHull(corners);
}

inline void Append(const TriangleMesh& more, TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& face : more.faces)
    mesh.faces.push_back({face[0] + first, face[1] + first, face[2] + first});
}

// A table of 1.2 x 0.8 x 0.75 m: a top of 4 cm and four legs of 5 cm, which end 1 mm under the top,
// so that each is closed by itself. 0.05 m3 all in all.
inline TriangleMesh TableMesh() {
  TriangleMesh mesh = BoxMesh({-0.6F, -0.4F, 0.71F}, {0.6F, 0.4F, 0.75F});
  for (const float x : {-0.55F, 0.5F}) {
    for (const float y : {-0.35F, 0.3F})
      Append(BoxMesh({x, y, 0}, {x + 0.05F, y + 0.05F, 0.709F}), mesh);
  }
  return mesh;
}
inline constexpr double kTableM3 = 1.2 * 0.8 * 0.04 + 4 * 0.05 * 0.05 * 0.709;

// A solid body of columns that stand on a square grid of 10 cm, each from its foot to its top in
// steps of 10 cm, with the sides between columns of different heights: one closed mesh.
struct Column {
  int foot = 0;
  int top = 0;
};
inline TriangleMesh ColumnsMesh(const std::vector<std::vector<Column>>& columns) {
  const auto filled = [&](int x, int y, int z) {
    if (x < 0 || y < 0 || x >= std::ssize(columns) || y >= std::ssize(columns[x])) return false;
    return columns[x][y].foot <= z && z < columns[x][y].top;
  };
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> numbers;
  const auto add_side = [&](const Eigen::Vector3i& cell, int axis, int sign) {
    Eigen::Vector3i along = Eigen::Vector3i::Unit((axis + 1) % 3);
    Eigen::Vector3i across = Eigen::Vector3i::Unit((axis + 2) % 3);
    if (sign < 0) std::swap(along, across);
    const Eigen::Vector3i corner = cell + (sign > 0 ? 1 : 0) * Eigen::Vector3i::Unit(axis);
    std::array<std::uint32_t, 4> side{};
    std::size_t n = 0;
    for (const Eigen::Vector3i& p : {corner,
                                     Eigen::Vector3i(corner + along),
                                     Eigen::Vector3i(corner + along + across),
                                     Eigen::Vector3i(corner + across)}) {
      const auto next = static_cast<std::uint32_t>(mesh.vertices.size());
      const auto [found, is_new] = numbers.try_emplace({p.x(), p.y(), p.z()}, next);
      if (is_new) mesh.vertices.emplace_back(0.1F * p.cast<float>());
      side[n++] = found->second;
    }
    mesh.faces.push_back({side[0], side[1], side[2]});
    mesh.faces.push_back({side[0], side[2], side[3]});
  };
  for (int x = 0; x < std::ssize(columns); ++x) {
    for (int y = 0; y < std::ssize(columns[x]); ++y) {
      for (int z = columns[x][y].foot; z < columns[x][y].top; ++z) {
        const Eigen::Vector3i cell(x, y, z);
        for (int axis = 0; axis < 3; ++axis) {
          for (const int sign : {-1, 1}) {
            const Eigen::Vector3i next = cell + sign * Eigen::Vector3i::Unit(axis);
            if (!filled(next.x(), next.y(), next.z())) add_side(cell, axis, sign);
          }
        }
      }
    }
  }
  return mesh;
}

}  // namespace deepslam::testing_support
