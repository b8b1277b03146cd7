#include "deepslam/fuse/object_masks.h"

#include <algorithm>
#include <cstdint>

namespace deepslam::fuse {
namespace {

void Cover(const Mask& part, Mask& whole) {
  if (whole.empty()) whole = Mask(part.width(), part.height());
  if (whole.width() != part.width() || whole.height() != part.height()) return;
  std::transform(
      whole.begin(), whole.end(), part.begin(), whole.begin(), [](std::uint8_t a, std::uint8_t b) {
        return static_cast<std::uint8_t>(a | b);
      });
}

}  // namespace

std::set<DetectionId> DetectionsOfMap(const OptimizedMap& map, const Association& association) {
  std::set<ObjectId> mapped;
  for (const MapObject& object : map.map.objects) mapped.insert(object.id);
  std::set<DetectionId> detections;
  for (const ObjectTrack& track : association.tracks) {
    if (!mapped.contains(track.id)) continue;
    for (const TrackMember& member : track.members) detections.insert(member.detection);
  }
  return detections;
}

ObjectMasks MasksByFrame(std::span<const FrameIdx> looked_at,
                         std::span<const FrameIdx> keyframes,
                         std::span<const Segment> segments) {
  ObjectMasks masks;
  for (const FrameIdx frame : looked_at) {
    if (std::ranges::binary_search(keyframes, frame)) masks[frame];
  }
  for (const Segment& segment : segments) masks[segment.frame].push_back(segment.mask);
  return masks;
}

Mask ObjectPixels(const ObjectMasks& masks, FrameIdx frame) {
  Mask whole;
  if (const auto of_frame = masks.find(frame); of_frame != masks.end()) {
    for (const PixelMask& mask : of_frame->second) Cover(mask.Unpacked(), whole);
  }
  return whole;
}

std::vector<FrameIdx> FramesWithMasks(std::span<const TrackedFrame> frames,
                                      const ObjectMasks& masks) {
  std::vector<FrameIdx> wanted;
  for (const TrackedFrame& frame : frames) {
    if (IsAligned(frame) && masks.contains(frame.frame)) wanted.push_back(frame.frame);
  }
  return wanted;
}

}  // namespace deepslam::fuse
