#include "deepslam/segment/surface_behind.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "deepslam/geometry/upright.h"

namespace deepslam::segment {
namespace {

constexpr double kMaxLean = 0.3;     // sine of a wall's angle to the vertical
constexpr double kMinOnPlane = 0.9;  // of the points
constexpr double kMinGoesOn = 0.6;   // of what is measured beside the box
constexpr int kMinMeasured_px = 30;  // beside the box, to say anything
constexpr double kRingShare = 0.2;   // of the box's longer side
constexpr int kMinRing_px = 8;       // that share of a small box would hold too few

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

// `box_px` in whole pixels, inclusive.
Strip LookAt(const Box2& box_px,
             const Plane& plane,
             const Plane& ground,
             const DepthImage& depth_m,
             const PinholeCamera& camera) {
  Strip strip;
  const int u_min = std::max(0, static_cast<int>(box_px.u_min));
  const int v_min = std::max(0, static_cast<int>(box_px.v_min));
  const int u_max = std::min(depth_m.width() - 1, static_cast<int>(box_px.u_max));
  const int v_max = std::min(depth_m.height() - 1, static_cast<int>(box_px.v_max));
  for (int v = v_min; v <= v_max; ++v) {
    for (int u = u_min; u <= u_max; ++u) {
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

Box2 BoxOf(const Region& region) {
  return {static_cast<double>(region.u_min),
          static_cast<double>(region.v_min),
          static_cast<double>(region.u_max),
          static_cast<double>(region.v_max)};
}

}  // namespace

bool IsSurfaceBehind(std::span<const PixelPoint> points,
                     const Region& region,
                     const DepthImage& depth_m,
                     const PinholeCamera& camera,
                     const std::optional<Plane>& ground_camera,
                     QuarterTurn upright) {
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
  const double ring = std::max(kMinRing_px, static_cast<int>(kRingShare * longer));
  const int width = depth_m.width();
  const int height = depth_m.height();
  const bool on_its_side = OnItsSide(upright);
  const auto goes_on = [&](const Box2& standing_px) {
    const Box2 box_px = Turned(
        standing_px, on_its_side ? height : width, on_its_side ? width : height, Inverse(upright));
    return LookAt(box_px, *plane, *ground_camera, depth_m, camera).GoesOn();
  };
  const Box2 box = Turned(BoxOf(region), width, height, upright);
  // Chairs in a row have others beside them in one plane, but none above.
  return goes_on({box.u_min, box.v_min - ring, box.u_max, box.v_min - 1}) &&
         (goes_on({box.u_min - ring, box.v_min, box.u_min - 1, box.v_max}) ||
          goes_on({box.u_max + 1, box.v_min, box.u_max + ring, box.v_max}));
}

}  // namespace deepslam::segment
