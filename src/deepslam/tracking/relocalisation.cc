#include "deepslam/tracking/relocalisation.h"

#include <deque>

namespace deepslam::tracking {

using alignment::FrameAlignment;

std::optional<Relocalisation> Relocalise(const PathSoFar& path, const PosedFrame& frame) {
  const std::deque<PosedFrame>& keyframes = path.keyframes.all();
  for (auto keyframe = keyframes.rbegin(); keyframe != keyframes.rend(); ++keyframe) {
    Starts starts{{path.previous.world_from_camera, keyframe->world_from_camera}, &*keyframe};
    if (const auto recorded = RecordedPose(path.previous, frame))
      starts.world_from_camera.insert(starts.world_from_camera.begin(), *recorded);
    const FrameAlignment found = Place(path, *keyframe, path.previous, frame, starts);
    const bool is_last = keyframe == keyframes.rbegin();
    if (!found.ok || (!is_last && !IsConfident(found))) continue;
    return Relocalisation{
        *keyframe,
        alignment::Sharpened(found, *keyframe->pyramid, *frame.pyramid, path.options.alignment)};
  }
  return std::nullopt;
}

}  // namespace deepslam::tracking
