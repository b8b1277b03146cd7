// Pictures of what was seen and is no object of the map.
#pragma once

#include <set>
#include <span>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/frames/frame_source.h"
#include "deepslam/report/report_content.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/optimized_map.h"

namespace deepslam::presentation {

// One for each, in their order, with its sentence as caption: the frame that shows it best with a
// box round it. No bytes where that frame is not of `shown`, cannot be read, or beyond the first
// 24.
[[nodiscard]] std::vector<report::Picture> NotMappedPictures(std::span<const NotMapped> not_mapped,
                                                             const OptimizedMap& map,
                                                             const FrameSource& frames,
                                                             const std::set<FrameIdx>& shown);

}  // namespace deepslam::presentation
