#include "deepslam/loop/keyframe_path.h"

#include <algorithm>
#include <cmath>

namespace deepslam::loop {

KeyframePath::KeyframePath(const Odometry& odometry, double drift_share)
    : keyframes_(odometry.keyframes) {
  std::vector<bool> broken(keyframes_.size(), false);  // between a keyframe and the one before
  odometry.ForEachEdge([&](const RelativePose& edge) {
    const int j = IndexOf(std::max(edge.i, edge.j));
    if (edge.composed && j >= 0) broken[static_cast<std::size_t>(j)] = true;
  });
  double length_m = 0;
  double drift_m = 0;
  int breaks = 0;
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    const TrackedFrame& frame = odometry.at(keyframes_[k]);
    if (k > 0) {
      const double step_m =
          (frame.world_from_camera.translation_m - poses_.back().translation_m).norm();
      const bool weak = frame.status != TrackingStatus::kTracked;
      length_m += std::isfinite(step_m) ? step_m : 0;
      drift_m += std::isfinite(step_m) ? (weak ? step_m : drift_share * step_m) : 0;
      if (broken[k]) ++breaks;
    }
    poses_.push_back(frame.world_from_camera);
    length_m_.push_back(length_m);
    drift_m_.push_back(drift_m);
    breaks_.push_back(breaks);
  }
}

int KeyframePath::IndexOf(FrameIdx keyframe) const {
  const auto at = std::lower_bound(keyframes_.begin(), keyframes_.end(), keyframe);
  if (at == keyframes_.end() || *at != keyframe) return -1;
  return static_cast<int>(at - keyframes_.begin());
}

double KeyframePath::Length_m(int a, int b) const {
  return std::abs(length_m_[static_cast<std::size_t>(a)] - length_m_[static_cast<std::size_t>(b)]);
}

double KeyframePath::Drift_m(int a, int b) const {
  return std::abs(drift_m_[static_cast<std::size_t>(a)] - drift_m_[static_cast<std::size_t>(b)]);
}

bool KeyframePath::Broken(int a, int b) const {
  return breaks_[static_cast<std::size_t>(a)] != breaks_[static_cast<std::size_t>(b)];
}

}  // namespace deepslam::loop
