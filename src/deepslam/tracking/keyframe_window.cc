#include "deepslam/tracking/keyframe_window.h"

#include <memory>
#include <utility>

#include "deepslam/alignment/reference_pixels.h"

namespace deepslam::tracking {

void MakeReference(PosedFrame& frame) {
  if (alignment::IsReference(*frame.pyramid)) return;
  frame.pyramid = std::make_shared<const FramePyramid>(alignment::AsReference(*frame.pyramid));
}

void KeyframeWindow::Push(PosedFrame keyframe) {
  MakeReference(keyframe);
  keyframes_.push_back(std::move(keyframe));
  while (keyframes_.size() > most_) keyframes_.pop_front();
}

void KeyframeWindow::GiveUpFrom(FrameIdx first) {
  std::erase_if(keyframes_, [&](const PosedFrame& keyframe) { return keyframe.frame >= first; });
}

void KeyframeWindow::Join(int sub_trajectory, int into, const Pose3& motion) {
  for (PosedFrame& keyframe : keyframes_) {
    if (keyframe.sub_trajectory != sub_trajectory) continue;
    keyframe.world_from_camera = motion * keyframe.world_from_camera;
    keyframe.sub_trajectory = into;
  }
}

std::vector<PlacedPyramid> KeyframeWindow::PlacedOf(int sub_trajectory) const {
  std::vector<PlacedPyramid> placed;
  for (const PosedFrame& keyframe : keyframes_) {
    if (keyframe.sub_trajectory == sub_trajectory) placed.push_back(keyframe.Placed());
  }
  return placed;
}

}  // namespace deepslam::tracking
