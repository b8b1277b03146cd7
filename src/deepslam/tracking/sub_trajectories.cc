#include "deepslam/tracking/sub_trajectories.h"

#include <algorithm>

namespace deepslam::tracking {

int SubTrajectories::Begin(FrameIdx start) {
  starts_.push_back(start);
  of_frames_[static_cast<std::size_t>(start.value)] = newest();
  return newest();
}

std::vector<std::size_t> SubTrajectories::Join(int sub_trajectory, int into) {
  std::vector<std::size_t> joined;
  const auto start = static_cast<std::size_t>(StartOf(sub_trajectory).value);
  for (std::size_t k = start; k < of_frames_.size(); ++k) {
    if (of_frames_[k] != sub_trajectory) continue;  // others came between two stays in this one
    of_frames_[k] = into;
    joined.push_back(k);
  }
  return joined;
}

void SubTrajectories::Reset() {
  starts_.resize(1);
  std::ranges::fill(of_frames_, 0);
}

}  // namespace deepslam::tracking
