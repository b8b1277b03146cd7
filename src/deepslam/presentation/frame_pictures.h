// Frames with the detections in them.
#pragma once

#include <set>
#include <span>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/report/report_content.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/optimized_map.h"

namespace deepslam::presentation {

// Up to six keyframes of `shown` with segments, evenly among them.
[[nodiscard]] std::vector<FrameIdx> FramesToPicture(std::span<const Segment> segments,
                                                    const OptimizedMap& map,
                                                    const std::set<FrameIdx>& shown);
// These frames with their segments; those of one object share a colour.
[[nodiscard]] std::vector<report::Picture> FramePictures(std::span<const FrameIdx> wanted,
                                                         std::span<const Segment> segments,
                                                         std::span<const ObjectTrack> tracks,
                                                         const OptimizedMap& map,
                                                         const FrameSource& frames);

}  // namespace deepslam::presentation
