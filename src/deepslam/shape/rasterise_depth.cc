#include "deepslam/shape/rasterise_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace deepslam::shape {
namespace {

constexpr double kNearPlaneM =
    0.01;  // the near plane, which cuts faces that reach behind the camera

// The part of a convex polygon before the near plane.
std::vector<Eigen::Vector3d> CutAtNear(const std::array<Eigen::Vector3d, 3>& corners) {
  std::vector<Eigen::Vector3d> kept;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d& a = corners[i];
    const Eigen::Vector3d& b = corners[(i + 1) % 3];
    if (a.z() >= kNearPlaneM) kept.push_back(a);
    if ((a.z() >= kNearPlaneM) != (b.z() >= kNearPlaneM))
      kept.push_back(a + (kNearPlaneM - a.z()) / (b.z() - a.z()) * (b - a));
  }
  return kept;
}

struct Projected {
  double u = 0;
  double v = 0;
  double inverse_z = 0;
};

void DrawTriangle(const Projected& a, const Projected& b, const Projected& c, DepthImage& depth_m) {
  const double area = (b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v);
  if (!std::isfinite(area) || area == 0) return;
  const auto first = [](double x, double y, double z, int last) {
    return static_cast<int>(
        std::clamp(std::ceil(std::min({x, y, z})), 0.0, static_cast<double>(last)));
  };
  const auto end = [](double x, double y, double z, int last) {
    return static_cast<int>(
        std::clamp(std::floor(std::max({x, y, z})), -1.0, static_cast<double>(last)));
  };
  const int u_first = first(a.u, b.u, c.u, depth_m.width());
  const int u_last = end(a.u, b.u, c.u, depth_m.width() - 1);
  const int v_first = first(a.v, b.v, c.v, depth_m.height());
  const int v_last = end(a.v, b.v, c.v, depth_m.height() - 1);
  for (int v = v_first; v <= v_last; ++v) {
    for (int u = u_first; u <= u_last; ++u) {
      const double weight_b = ((u - a.u) * (c.v - a.v) - (c.u - a.u) * (v - a.v)) / area;
      const double weight_c = ((b.u - a.u) * (v - a.v) - (u - a.u) * (b.v - a.v)) / area;
      const double weight_a = 1 - weight_b - weight_c;
      if (weight_a < 0 || weight_b < 0 || weight_c < 0) continue;
      // 1 / z is linear in the image.
      const auto z = static_cast<float>(
          1.0 / (weight_a * a.inverse_z + weight_b * b.inverse_z + weight_c * c.inverse_z));
      float& nearest = depth_m(u, v);
      if (nearest == 0 || z < nearest) nearest = z;
    }
  }
}

}  // namespace

DepthImage RasteriseDepth(const TriangleMesh& mesh,
                          const Pose3& camera_from_mesh,
                          const PinholeCamera& camera) {
  DepthImage depth_m(camera.width, camera.height, 0.0f);
  for (const std::array<std::uint32_t, 3>& face : mesh.faces) {
    std::array<Eigen::Vector3d, 3> corners;
    bool usable = true;
    for (std::size_t i = 0; i < 3 && usable; ++i) {
      usable = face[i] < mesh.vertices.size() && mesh.vertices[face[i]].allFinite();
      if (usable) corners[i] = camera_from_mesh * mesh.vertices[face[i]].cast<double>();
    }
    if (!usable) continue;
    std::vector<Projected> polygon;
    for (const Eigen::Vector3d& p : CutAtNear(corners)) {
      polygon.push_back({camera.fx * p.x() / p.z() + camera.cx,
                         camera.fy * p.y() / p.z() + camera.cy,
                         1.0 / p.z()});
    }
    for (std::size_t i = 2; i < polygon.size(); ++i)
      DrawTriangle(polygon[0], polygon[i - 1], polygon[i], depth_m);
  }
  return depth_m;
}

}  // namespace deepslam::shape
