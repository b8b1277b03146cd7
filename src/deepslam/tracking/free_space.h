// Free-space violation: surfaces of placed frames that stand where others saw through to something
// behind. Either they have moved in between, or a frame is placed wrongly.
#pragma once

#include <memory>
#include <span>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/core/image.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::tracking {

using alignment::FramePyramid;
using alignment::PyramidLevel;

struct PlacedPyramid {
  std::shared_ptr<const FramePyramid> pyramid;
  Pose3 world_from_camera;
};

// The level that free space is looked at: the coarsest that frames are aligned at, quick, and fine
// enough for an arm.
[[nodiscard]] const PyramidLevel& FreeSpaceLevel(const FramePyramid& pyramid);

// Pixels of a frame at FreeSpaceLevel, 0 or 1.
struct FreeSpaceMasks {
  Mask violating;  // the surface stands where an observer saw free space
  Mask observed;   // any observer has it in view, and not hidden behind what it sees
};

// By the last of `observers` that has the pixel's place in view. All pyramids of one camera and as
// many levels.
[[nodiscard]] FreeSpaceMasks ObserveFreeSpace(const PlacedPyramid& frame,
                                              std::span<const PlacedPyramid> observers,
                                              const DepthNoise& noise);

// Two groups of frames, each placed rightly in itself. Of the surfaces of one that frames of the
// other observe, the share that violates their free space; the larger of both ways. Next to nothing
// where the groups are placed rightly and nothing has moved in between: real captures leave up to
// 1 %. At a wrong place much may fit, as walls and floors do in many places, but then something
// stands in what the others saw empty. 0 where neither observes anything.
[[nodiscard]] double FreeSpaceViolation(std::span<const PlacedPyramid> a,
                                        std::span<const PlacedPyramid> b,
                                        const DepthNoise& noise);

}  // namespace deepslam::tracking
