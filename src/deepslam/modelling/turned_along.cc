#include "deepslam/modelling/turned_along.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "deepslam/core/angles.h"

namespace deepslam::modelling {
namespace {

// The measured boxes of 14 tables of seven homes are off by 0.4 degrees in the median and 1.3 at
// most but for one in ten, registered models by 0.3 and 2.4 and by 4 on redkitchen: where the two
// differ by more, the model is wrong.
constexpr double kLeastTurnRad = 2 * kRadPerDeg;
constexpr double kMostTurnRad = 10 * kRadPerDeg;  // farther off they are not of one thing

}  // namespace

Pose3 TurnedAlong(const Pose3& world_from_object, const Pose3& world_from_measured) {
  const Eigen::Vector3d side_object = world_from_object.rotation.conjugate() *
                                      (world_from_measured.rotation * Eigen::Vector3d::UnitX());
  const double turn_rad =
      std::remainder(std::atan2(side_object.y(), side_object.x()), 0.5 * std::numbers::pi);
  if (std::abs(turn_rad) < kLeastTurnRad || std::abs(turn_rad) > kMostTurnRad)
    return world_from_object;
  Pose3 turned = world_from_object;
  turned.rotation = turned.rotation * Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ());
  return turned;
}

}  // namespace deepslam::modelling
