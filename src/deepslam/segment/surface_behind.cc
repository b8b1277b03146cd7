#include "deepslam/segment/surface_behind.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace deepslam::segment {
namespace {

constexpr double kMaxLean = 0.3;     // sine of a wall's angle to the vertical
constexpr double kMinOnPlane = 0.9;  // of the points
constexpr double kMinGoesOn = 0.6;   // of what is measured beside the box
constexpr int kMinMeasured_px = 30;  // beside the box, to say anything
constexpr double kRingShare = 0.2;   // of the box's longer side
constexpr int kMinRing_px = 8;

double Tolerance_m(double depth_m) { return 0.02 + 0.006 * depth_m * depth_m; }

std::optional<Plane> PlaneThrough(std::span<const PixelPoint> points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  for (const PixelPoint& point : points) {
    const Eigen::Vector3d p = point.p_camera.cast<double>();
    sum += p;
    products += p * p.transpose();
  }
  const double count = static_cast<double>(points.size());
  if (points.size() < 3) return std::nullopt;
  const Eigen::Vector3d mean = sum / count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(products / count -
                                                              mean * mean.transpose());
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  if (!normal.allFinite()) return std::nullopt;
  return Plane{normal, -normal.dot(mean)};
}

// What was measured in a rectangle of the image above the ground, and how much of it lies on the
// plane.
struct Strip {
  int num_measured = 0;
  int num_on_plane = 0;

  [[nodiscard]] bool GoesOn() const {
    return num_measured >= kMinMeasured_px && num_on_plane >= kMinGoesOn * num_measured;
  }
};

Strip LookAt(int u_min,
             int v_min,
             int u_max,
             int v_max,
             const Plane& plane,
             const Plane& ground,
             const DepthImage& depth_m,
             const PinholeCamera& camera) {
  Strip strip;
  for (int v = std::max(0, v_min); v <= std::min(depth_m.height() - 1, v_max); ++v) {
    for (int u = std::max(0, u_min); u <= std::min(depth_m.width() - 1, u_max); ++u) {
      const double depth = static_cast<double>(depth_m(u, v));
      if (!(depth > 0)) continue;
      const Eigen::Vector3d p = camera.Unproject(u, v, depth);
      if (ground.SignedDistance(p) < 2 * Tolerance_m(depth)) continue;
      ++strip.num_measured;
      if (std::abs(plane.SignedDistance(p)) <= Tolerance_m(depth)) ++strip.num_on_plane;
    }
  }
  return strip;
}

}  // namespace

bool IsSurfaceBehind(std::span<const PixelPoint> points,
                     const Region& region,
                     const DepthImage& depth_m,
                     const PinholeCamera& camera,
                     const std::optional<Plane>& ground_camera) {
  if (!ground_camera || region.empty()) return false;
  const std::optional<Plane> plane = PlaneThrough(points);
  if (!plane || std::abs(plane->normal.dot(ground_camera->normal)) > kMaxLean) return false;
  const auto num_on_plane = std::count_if(points.begin(), points.end(), [&](const PixelPoint& p) {
    const Eigen::Vector3d p_camera = p.p_camera.cast<double>();
    return std::abs(plane->SignedDistance(p_camera)) <= Tolerance_m(p_camera.z());
  });
  if (static_cast<double>(num_on_plane) < kMinOnPlane * static_cast<double>(points.size()))
    return false;
  const int longer = std::max(region.u_max - region.u_min, region.v_max - region.v_min) + 1;
  const int ring = std::max(kMinRing_px, static_cast<int>(kRingShare * longer));
  const auto goes_on = [&](int u_min, int v_min, int u_max, int v_max) {
    return LookAt(u_min, v_min, u_max, v_max, *plane, *ground_camera, depth_m, camera).GoesOn();
  };
  // Chairs in a row have others beside them in one plane, but none above.
  return goes_on(region.u_min, region.v_min - ring, region.u_max, region.v_min - 1) &&
         (goes_on(region.u_min - ring, region.v_min, region.u_min - 1, region.v_max) ||
          goes_on(region.u_max + 1, region.v_min, region.u_max + ring, region.v_max));
}

}  // namespace deepslam::segment
