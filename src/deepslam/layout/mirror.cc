#include "deepslam/layout/mirror.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace deepslam::layout {
namespace {

// Cubes of this size, a mirrored vertex's or one beside it, hold a vertex of the surface.
constexpr float kCube_m = 0.08F;
// Share of the vertices: a mirror shows some that the room's own views do not.
constexpr double kMirroredShare = 0.7;
constexpr std::size_t kFewestVertices = 100;  // vertices that say anything

using Cube = std::array<int, 3>;

Cube CubeOf(const Eigen::Vector3f& p) {
  const Eigen::Array3i cube = (p / kCube_m).array().floor().cast<int>();
  return {cube.x(), cube.y(), cube.z()};
}

}  // namespace

bool IsMirrored(const CoarseSurface& surface,
                const std::vector<std::uint32_t>& vertices,
                const WallLine& line) {
  if (vertices.size() < kFewestVertices) return false;
  std::vector<Cube> cubes;
  cubes.reserve(surface.mesh.vertices.size());
  for (const Eigen::Vector3f& p : surface.mesh.vertices) cubes.push_back(CubeOf(p));
  std::sort(cubes.begin(), cubes.end());
  cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
  const auto occupied = [&](const Eigen::Vector3f& p) {
    const Cube middle = CubeOf(p);
    for (int n = 0; n < 27; ++n) {
      const Cube cube = {middle[0] + n / 9 - 1, middle[1] + n / 3 % 3 - 1, middle[2] + n % 3 - 1};
      if (std::binary_search(cubes.begin(), cubes.end(), cube)) return true;
    }
    return false;
  };
  std::size_t num_on = 0;
  for (const std::uint32_t v : vertices) {
    Eigen::Vector3f p = surface.mesh.vertices[v];
    const double distance_m = line.Distance(p.head<2>().cast<double>());
    p.head<2>() -= (2 * distance_m * line.normal).cast<float>();
    num_on += occupied(p) ? 1 : 0;
  }
  return static_cast<double>(num_on) > kMirroredShare * static_cast<double>(vertices.size());
}

}  // namespace deepslam::layout
