// The last keyframes of a path: what a frame is aligned to, and found again at.
#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "deepslam/tracking/posed_frame.h"

namespace deepslam::tracking {

// Makes the frame's pyramid a reference (alignment/reference_pixels.h): only to such frames can be
// aligned.
void MakeReference(PosedFrame& frame);

class KeyframeWindow {
 public:
  // Of at most so many keyframes, the last ones; at least 1.
  explicit KeyframeWindow(int most) : most_(static_cast<std::size_t>(most)) {}

  // As a reference.
  void Push(PosedFrame keyframe);
  void Clear() { keyframes_.clear(); }
  // Keyframes from `first` on are none any more.
  void GiveUpFrom(FrameIdx first);
  // Those of a sub-trajectory become part of another one and move with it, in the world.
  void Join(int sub_trajectory, int into, const Pose3& motion);

  [[nodiscard]] bool empty() const { return keyframes_.empty(); }
  // The oldest first.
  [[nodiscard]] const std::deque<PosedFrame>& all() const { return keyframes_; }
  [[nodiscard]] const PosedFrame& last() const { return keyframes_.back(); }
  [[nodiscard]] std::vector<PlacedPyramid> PlacedOf(int sub_trajectory) const;

 private:
  std::size_t most_;
  std::deque<PosedFrame> keyframes_;
};

}  // namespace deepslam::tracking
