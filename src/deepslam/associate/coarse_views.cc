#include "deepslam/associate/coarse_views.h"

#include <utility>

namespace deepslam::associate {
namespace {

DepthImage Coarse(const DepthImage& depth_m) {
  DepthImage coarse(depth_m.width() / kCoarseStep, depth_m.height() / kCoarseStep);
  for (int v = 0; v < coarse.height(); ++v) {
    for (int u = 0; u < coarse.width(); ++u) {
      coarse(u, v) = depth_m(u * kCoarseStep + kCoarseStep / 2, v * kCoarseStep + kCoarseStep / 2);
    }
  }
  return coarse;
}

}  // namespace

void CoarseViews::Add(FrameIdx frame, const Pose3& camera_from_world, const DepthImage& depth_m) {
  if (num_added_++ % every_ != 0) return;
  if (held_.size() == capacity_) {
    for (std::size_t n = 1; 2 * n < held_.size(); ++n) held_[n] = std::move(held_[2 * n]);
    held_.resize((held_.size() + 1) / 2);
    every_ *= 2;
    if ((num_added_ - 1) % every_ != 0) return;
  }
  held_.push_back({frame, camera_from_world, Coarse(depth_m)});
}

}  // namespace deepslam::associate
