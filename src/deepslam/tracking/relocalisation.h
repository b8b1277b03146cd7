// A frame that lies neither where the camera was expected nor near the frame before, found again at
// an earlier keyframe.
#pragma once

#include <optional>

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/tracking/placement.h"

namespace deepslam::tracking {

struct Relocalisation {
  PosedFrame keyframe;
  alignment::FrameAlignment alignment;  // of the frame to it
};

// At the latest keyframe that the frame fits: surely where it is not the last one, as elsewhere
// some earlier keyframe nearly always fits somehow, and a new sub-trajectory is joined when it is
// sure where.
[[nodiscard]] std::optional<Relocalisation> Relocalise(const PathSoFar& path,
                                                       const PosedFrame& frame);

}  // namespace deepslam::tracking
