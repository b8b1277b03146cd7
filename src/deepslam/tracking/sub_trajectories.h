// Connected components of the path: frames that are aligned to each other. Behind a loss a new one
// begins, at a place that is only guessed, until one of its keyframes is found at a keyframe of an
// earlier one, and it joins that.
#pragma once

#include <cstddef>
#include <vector>

#include "deepslam/core/ids.h"

namespace deepslam::tracking {

// Numbered as they begin; the first is 0 and begins with the capture.
class SubTrajectories {
 public:
  // Of the next frame.
  void Add(int sub_trajectory) { of_frames_.push_back(sub_trajectory); }
  // A new one, from a frame on that was added already. Its number.
  int Begin(FrameIdx start);
  // The frames of one become part of an earlier one; gives their places in the capture.
  std::vector<std::size_t> Join(int sub_trajectory, int into);
  // All frames so far belong to the first again, and there is no other.
  void Reset();

  [[nodiscard]] int newest() const { return static_cast<int>(starts_.size()) - 1; }
  [[nodiscard]] int Of(FrameIdx frame) const {
    return of_frames_[static_cast<std::size_t>(frame.value)];
  }
  [[nodiscard]] FrameIdx StartOf(int sub_trajectory) const {
    return starts_[static_cast<std::size_t>(sub_trajectory)];
  }

 private:
  std::vector<int> of_frames_;
  std::vector<FrameIdx> starts_{FrameIdx{0}};  // the first frame of each
};

}  // namespace deepslam::tracking
