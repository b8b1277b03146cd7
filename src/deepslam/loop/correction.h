// Corrections of four degrees of freedom: yaw about the up direction, and translation. Work is done
// in the level frame, the world turned so that up is z.
#pragma once

#include <vector>

#include "deepslam/scene/object_map.h"

namespace deepslam::loop {

// Common up direction of the map's objects, which stand upright: their mean z axis, again without
// those more than 20 deg off. z without objects.
[[nodiscard]] Eigen::Vector3d UpDirection(const ObjectMap& map);

[[nodiscard]] Eigen::Quaterniond LevelFromWorld(const Eigen::Vector3d& up_world);

struct LevelCorrection {
  double yaw_rad = 0;
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& p_level) const {
    return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * p_level + translation_m;
  }
  [[nodiscard]] Pose3 InWorld(const Eigen::Quaterniond& level_from_world) const;
};

// Weighted sums of a least-squares fit over point pairs and yaw differences.
class CorrectionFit {
 public:
  void AddPoint(const Eigen::Vector3d& old_level, const Eigen::Vector3d& new_level) {
    old_.push_back(old_level);
    new_.push_back(new_level);
  }
  // An object's yaw in the old observation minus its yaw in the new one.
  void AddYaw(double difference_rad) { yaws_rad_.push_back(difference_rad); }

  // Points and yaws weigh by their deviations; a weak preference for no turn decides where neither
  // does. No points: identity.
  [[nodiscard]] LevelCorrection Solve(double point_deviation_m, double yaw_deviation_rad) const;

 private:
  std::vector<Eigen::Vector3d> old_;
  std::vector<Eigen::Vector3d> new_;
  std::vector<double> yaws_rad_;
};

// In (-pi, pi].
[[nodiscard]] double WrappedAngle(double angle_rad);

}  // namespace deepslam::loop
