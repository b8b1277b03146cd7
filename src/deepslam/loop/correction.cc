#include "deepslam/loop/correction.h"

#include <cmath>
#include <numbers>

#include "deepslam/geometry/plane.h"

namespace deepslam::loop {
namespace {

constexpr double kUprightCosine = 0.94;  // 20 deg
// So weak that it decides only where no point tells of a turn.
constexpr double kNoTurnDeviation_rad = 1.0;

}  // namespace

Eigen::Vector3d UpDirection(const ObjectMap& map) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  const auto axis = [](const MapObject& object) -> Eigen::Vector3d {
    return object.world_from_object.rotation * Eigen::Vector3d::UnitZ();
  };
  for (const MapObject& object : map.objects) {
    if (axis(object).allFinite()) up += axis(object);
  }
  if (up.norm() < 1e-6) return Eigen::Vector3d::UnitZ();
  up.normalize();
  Eigen::Vector3d agreed = Eigen::Vector3d::Zero();
  for (const MapObject& object : map.objects) {
    if (axis(object).dot(up) > kUprightCosine) agreed += axis(object);
  }
  return agreed.norm() < 1e-6 ? up : agreed.normalized();
}

Eigen::Quaterniond LevelFromWorld(const Eigen::Vector3d& up_world) {
  return ShortestRotation(up_world, Eigen::Vector3d::UnitZ());
}

Pose3 LevelCorrection::InWorld(const Eigen::Quaterniond& level_from_world) const {
  const Pose3 level{Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())),
                    translation_m};
  const Pose3 turn{level_from_world, Eigen::Vector3d::Zero()};
  return turn.Inverse() * level * turn;
}

LevelCorrection CorrectionFit::Solve(double point_deviation_m, double yaw_deviation_rad) const {
  if (old_.empty()) return {};
  Eigen::Vector3d old_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d new_mean = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < old_.size(); ++k) {
    old_mean += old_[k];
    new_mean += new_[k];
  }
  old_mean /= static_cast<double>(old_.size());
  new_mean /= static_cast<double>(new_.size());

  const double point_weight = 1.0 / (point_deviation_m * point_deviation_m);
  const double yaw_weight = 1.0 / (yaw_deviation_rad * yaw_deviation_rad);
  double sine = 0;
  double cosine = 1.0 / (kNoTurnDeviation_rad * kNoTurnDeviation_rad);
  for (std::size_t k = 0; k < old_.size(); ++k) {
    const Eigen::Vector3d a = new_[k] - new_mean;
    const Eigen::Vector3d b = old_[k] - old_mean;
    sine += point_weight * (a.x() * b.y() - a.y() * b.x());
    cosine += point_weight * (a.x() * b.x() + a.y() * b.y());
  }
  for (const double yaw : yaws_rad_) {
    sine += yaw_weight * std::sin(yaw);
    cosine += yaw_weight * std::cos(yaw);
  }
  LevelCorrection correction;
  correction.yaw_rad = std::atan2(sine, cosine);
  correction.translation_m = old_mean - correction * new_mean;
  return correction;
}

double WrappedAngle(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

}  // namespace deepslam::loop
