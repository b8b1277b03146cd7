// What has moved since earlier keyframes: people, doors, chairs that are pushed. Nothing is to be
// aligned to it.
//
// A surface that stands where an earlier frame saw through to something behind
// (tracking/free_space.h) cannot have stood there then. The rule needs no motion of its own to be
// told apart from the camera's, and says nothing of what merely comes out from behind something.
#pragma once

#include <memory>
#include <span>

#include "deepslam/core/image.h"
#include "deepslam/tracking/free_space.h"

namespace deepslam::tracking {

// Pixels of the frame at FreeSpaceLevel, 0 or 1, that have moved since `earlier` (latest last,
// poses right to a few centimetres): where several observed a place, the latest one counts; what
// none observed goes with what it hangs together with. All pyramids of one camera and as many
// levels.
[[nodiscard]] Mask DynamicMask(const PlacedPyramid& frame,
                               std::span<const PlacedPyramid> earlier,
                               const DepthNoise& noise);

// The frame without the depth under its dynamic mask and just around it. The same pyramid where
// that is little of the frame.
[[nodiscard]] std::shared_ptr<const alignment::FramePyramid> WithoutDynamic(
    const PlacedPyramid& frame, std::span<const PlacedPyramid> earlier, const DepthNoise& noise);

}  // namespace deepslam::tracking
