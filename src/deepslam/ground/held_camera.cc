#include "deepslam/ground/held_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "deepslam/core/angles.h"
#include "deepslam/ground/plane_fit.h"

namespace deepslam::ground {
namespace {

// Grounds of real and rendered captures have 1.0, and 52 deg and more; walls up to 1.0 within 20
// deg, or 0.2 to 0.3 within 90 to 100.
constexpr double kLeastHeld = 0.9;
// Of a ground that is possible at all, with a hand's roll as well.
constexpr double kLeastHeldAtAll = 0.5;
constexpr double kLeastHeadingsDeg = 40;  // between the 20 of walls and the 52 of grounds
constexpr double kLeastSeen = 0.05;  // of the keyframes; a plane that fewer see decides nothing
constexpr double kLevelDeg = 8;      // spread of a hand's roll
constexpr double kMostRollSpreadDeg = 2 * kLevelDeg;     // of a ground that is sure
constexpr double kWildestRollSpreadDeg = 4 * kLevelDeg;  // of a ground that is possible at all
// As much as speaks for the pictures as they are.
constexpr double kTimesAsMuch = 3;
// Of evidence, 0 to 1: half a turn makes a floor of a ceiling.
constexpr double kNextToNothing = 0.02;

// What is left of the circle without the widest gap.
double CoveredDeg(std::vector<double> headings_rad) {
  if (headings_rad.size() < 2) return 0;
  std::ranges::sort(headings_rad);
  double widest = headings_rad.front() + 2 * std::numbers::pi - headings_rad.back();
  for (std::size_t k = 1; k < headings_rad.size(); ++k)
    widest = std::max(widest, headings_rad[k] - headings_rad[k - 1]);
  return 360 - widest * kDegPerRad;
}

double HeadingsDeg(const Plane& plane_world, std::span<const TrackedFrame> keyframes) {
  const Eigen::Matrix<double, 3, 2> level = GroundTangentBasis(plane_world.normal);
  std::vector<double> headings_rad;
  for (const TrackedFrame& keyframe : keyframes) {
    const Eigen::Vector2d ahead =
        level.transpose() * (keyframe.world_from_camera.rotation * Eigen::Vector3d::UnitZ());
    headings_rad.push_back(std::atan2(ahead.y(), ahead.x()));
  }
  return CoveredDeg(std::move(headings_rad));
}

// Of the normal's direction in the pictures: standard deviation on the circle.
double RollSpreadDeg(const Plane& plane_world, std::span<const TrackedFrame> keyframes) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const TrackedFrame& keyframe : keyframes) {
    const Eigen::Vector3d up_camera =
        keyframe.world_from_camera.rotation.inverse() * plane_world.normal;
    sum += up_camera.head<2>().normalized();
  }
  const double mean = sum.norm() / static_cast<double>(keyframes.size());
  return kDegPerRad * std::sqrt(-2 * std::log(std::clamp(mean, 1e-9, 1.0)));
}

}  // namespace

Holding MeasureHolding(const Ground& ground,
                       std::span<const TrackedFrame> keyframes,
                       QuarterTurn upright) {
  if (!ground.plane_world || keyframes.empty()) return {};
  const auto is_held = [&](const TrackedFrame& keyframe) {
    const Plane plane_camera =
        Transformed(keyframe.world_from_camera.Inverse(), *ground.plane_world);
    return PermissibleOrientation(plane_camera, upright);
  };
  const auto num_keyframes = static_cast<double>(keyframes.size());
  return {static_cast<double>(std::ranges::count_if(keyframes, is_held)) / num_keyframes,
          static_cast<double>(ground.observations.size()) / num_keyframes,
          HeadingsDeg(*ground.plane_world, keyframes),
          RollSpreadDeg(*ground.plane_world, keyframes)};
}

bool Convinces(const Holding& holding) {
  return holding.held_share >= kLeastHeld && holding.seen_share >= kLeastSeen &&
         holding.headings_deg >= kLeastHeadingsDeg && holding.roll_spread_deg <= kMostRollSpreadDeg;
}

bool IsPossible(const Holding& holding) {
  return holding.held_share >= kLeastHeld || (holding.held_share >= kLeastHeldAtAll &&
                                              holding.roll_spread_deg <= kWildestRollSpreadDeg);
}

double Evidence(const Holding& holding) {
  const double turned = std::min(1.0, holding.headings_deg / kLeastHeadingsDeg);
  const double level = 1 / (1 + std::pow(holding.roll_spread_deg / kLevelDeg, 2));
  return holding.held_share * holding.seen_share * turned * level;
}

bool Outweighs(const Holding& turned, QuarterTurn turn, const Holding& as_is) {
  if (!Convinces(turned)) return false;
  if (turn == QuarterTurn::kHalf) return Evidence(as_is) < kNextToNothing;
  return Evidence(turned) >= kTimesAsMuch * Evidence(as_is);
}

}  // namespace deepslam::ground
