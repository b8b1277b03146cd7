// How far tracking can have drifted between two keyframes.
#pragma once

#include <vector>

#include "deepslam/geometry/pose.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::loop {

class KeyframePath {
 public:
  // `drift_share`: drift per travelled metre; parts that tracking calls weakly constrained
  // count with 1.
  KeyframePath(const Odometry& odometry, double drift_share);

  // Positions in odometry.keyframes; -1 for a frame that is none.
  [[nodiscard]] int IndexOf(FrameIdx keyframe) const;
  [[nodiscard]] const Pose3& world_from_camera(int index) const {
    return poses_[static_cast<std::size_t>(index)];
  }
  // In any order.
  [[nodiscard]] double Length_m(int a, int b) const;
  [[nodiscard]] double Drift_m(int a, int b) const;
  // Tracking was lost between them: nothing is known of the drift.
  [[nodiscard]] bool Broken(int a, int b) const;

 private:
  std::vector<FrameIdx> keyframes_;
  std::vector<Pose3> poses_;
  // Sums until each keyframe.
  std::vector<double> length_m_;
  std::vector<double> drift_m_;
  std::vector<int> breaks_;
};

}  // namespace deepslam::loop
