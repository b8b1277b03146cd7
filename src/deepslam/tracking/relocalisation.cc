#include "deepslam/tracking/relocalisation.h"

#include <deque>

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;

// At the latest keyframe that `place` finds the frame at.
template <typename PlaceAt>
std::optional<Relocalisation> AtLatest(const PathSoFar& path,
                                       const PosedFrame& frame,
                                       const PlaceAt& place_at) {
  const std::deque<PosedFrame>& keyframes = path.keyframes.all();
  for (auto keyframe = keyframes.rbegin(); keyframe != keyframes.rend(); ++keyframe) {
    const FrameAlignment found = place_at(*keyframe);
    const bool is_last = keyframe == keyframes.rbegin();
    if (!found.ok || (!is_last && !IsConfident(found))) continue;
    return Relocalisation{
        *keyframe,
        alignment::Sharpened(found, *keyframe->pyramid, *frame.pyramid, path.options.alignment)};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Relocalisation> Relocalise(const PathSoFar& path, const PosedFrame& frame) {
  const auto by_features = AtLatest(path, frame, [&](const PosedFrame& keyframe) {
    return PlaceByFeatures(path, keyframe, path.previous, frame);
  });
  if (by_features) return by_features;
  return AtLatest(path, frame, [&](const PosedFrame& keyframe) {
    Starts starts{{path.previous.world_from_camera, keyframe.world_from_camera}, &keyframe};
    if (const auto recorded = RecordedPose(path.previous, frame))
      starts.world_from_camera.insert(starts.world_from_camera.begin(), *recorded);
    return Place(path, keyframe, path.previous, frame, starts);
  });
}

}  // namespace deepslam::tracking
