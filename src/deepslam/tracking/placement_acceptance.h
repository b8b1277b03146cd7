// Whether an alignment can be a frame's place. In rooms most frames fit somewhere: walls, floors
// and corners are alike. So what an alignment has to show depends on how likely its motion is.
#pragma once

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/tracking/placement.h"

namespace deepslam::tracking {

// Share of free space that keyframes and a frame may violate where no hand would have carried the
// camera, and where sub-trajectories are joined: more where images correlate as at no wrong place,
// so that something has moved.
[[nodiscard]] inline double MaxViolationFar(const alignment::FrameAlignment& found) {
  return found.intensity_correlation >= kSameImage ? 0.05 : 0.01;
}

// What fits where the camera was expected is taken for it, whatever has moved: unless it looks like
// another place as well. Elsewhere most frames fit somehow, so nothing may speak against it; and
// where no hand would have carried the camera, all has to speak for it. Of `found`, an ok alignment
// of `frame` to `reference`, of a camera that was at `last` before.
[[nodiscard]] bool IsAcceptable(const PathSoFar& path,
                                const PosedFrame& reference,
                                const PosedFrame& last,
                                const PosedFrame& frame,
                                const alignment::FrameAlignment& found);

// By points that frame and reference share, where depth is so poor that it cannot bear an alignment
// out (holes, edges that smear): it lies where they say, fits as far as it is measured, a hand may
// have carried the camera there, and details are alike.
[[nodiscard]] bool IsBorneOutByFeatures(const PathSoFar& path,
                                        const PosedFrame& reference,
                                        const PosedFrame& last,
                                        const PosedFrame& frame,
                                        const alignment::FrameAlignment& found,
                                        const FeatureStart& start);

}  // namespace deepslam::tracking
