#include "deepslam/ground/reidentify.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "deepslam/core/angles.h"
#include "deepslam/ground/plane_fit.h"

namespace deepslam::ground {
namespace {

constexpr double kStandardDeviations = 3;  // of the propagated plane: 99.7 % of normal errors
constexpr double kMaxReachM = 0.3;         // m: less than the height of a seat or a table top
constexpr double kMaxReachRad = 12 * kRadPerDeg;  // steeper ones are ramps and things that lean
// What lies below must be this share of what lies on the plane: stray depth is less.
constexpr double kMinShareBelow = 0.15;
constexpr double kOnPlaneM = 0.05;  // m: noise of depth, and drift between the keyframes about

}  // namespace

Reach ReachOf(const Eigen::Matrix3d& information) {
  const Eigen::Matrix3d covariance = information.inverse();
  const double angle_rad = std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
  return {std::min(kStandardDeviations * std::sqrt(covariance(2, 2)), kMaxReachM),
          std::min(kStandardDeviations * angle_rad, kMaxReachRad)};
}

bool IsWide(const Reach& reach) {
  return reach.distance_m > kMaxShiftM || reach.turn_rad > kMaxTurnRad;
}

std::vector<Plane> PlanesWithin(std::span<const PlaneSighting> of_keyframe,
                                const Plane& predicted_camera,
                                const Reach& reach) {
  std::vector<Plane> within;
  for (const PlaneSighting& sighting : of_keyframe) {
    const Plane& plane = sighting.plane_camera;
    const double turn_rad =
        std::acos(std::clamp(plane.normal.dot(predicted_camera.normal), -1.0, 1.0));
    if (turn_rad <= std::max(reach.turn_rad, kMaxTurnRad) &&
        std::abs(plane.d_m - predicted_camera.d_m) <= std::max(reach.distance_m, kMaxShiftM))
      within.push_back(plane);
  }
  return within;
}

bool IsLowest(const Plane& plane_world, std::span<const KeyframeSample> samples) {
  const Eigen::Vector3f normal = plane_world.normal.cast<float>();
  const auto d_m = static_cast<float>(plane_world.d_m);
  const auto below_m = static_cast<float>(-GroundOptions::kLevelSeparation_m);
  std::size_t below = 0;
  std::size_t on = 0;
  for (const KeyframeSample& sample : samples) {
    for (const Eigen::Vector3f& p_world : sample.points_world) {
      const float height_m = normal.dot(p_world) + d_m;
      below += height_m < below_m ? 1 : 0;
      on += std::abs(height_m) < static_cast<float>(kOnPlaneM) ? 1 : 0;
    }
  }
  return static_cast<double>(below) < kMinShareBelow * static_cast<double>(on);
}

}  // namespace deepslam::ground
