// Closed meshes with known volumes.
#pragma once

#include <array>
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

}  // namespace deepslam::testing_support
