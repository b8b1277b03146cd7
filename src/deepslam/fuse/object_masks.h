// The pixels of objects that the room's surface is fused without.
#pragma once

#include <map>
#include <set>
#include <span>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/core/image.h"
#include "deepslam/frames/pixel_mask.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/optimized_map.h"

namespace deepslam::fuse {

// Per frame whose objects are known their pixels; none where nothing was found.
using ObjectMasks = std::map<FrameIdx, std::vector<PixelMask>>;

// The detections of objects that are in the map.
[[nodiscard]] std::set<DetectionId> DetectionsOfMap(const OptimizedMap& map,
                                                    const Association& association);

// Of the frames with `segments`, which are the objects', and of the keyframes (ascending) that the
// detector looked at. Other frames that it looked at may only have voted: objects have no outlines
// there.
[[nodiscard]] ObjectMasks MasksByFrame(std::span<const FrameIdx> looked_at,
                                       std::span<const FrameIdx> keyframes,
                                       std::span<const Segment> segments);

// The pixels of all objects of a frame, 1 where there is one; empty where there are none.
[[nodiscard]] Mask ObjectPixels(const ObjectMasks& masks, FrameIdx frame);

// Of the aligned frames those with masks, in order: others would fuse objects.
[[nodiscard]] std::vector<FrameIdx> FramesWithMasks(std::span<const TrackedFrame> frames,
                                                    const ObjectMasks& masks);

}  // namespace deepslam::fuse
