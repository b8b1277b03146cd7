// What has moved between frames: people, doors, chairs that are pushed; or a frame that is placed
// wrongly.
//
// A surface that stands where an earlier frame saw through to something behind cannot have stood
// there then. The rule needs no motion of its own to be told apart from the camera's, and says
// nothing of what merely comes out from behind something.
#pragma once

#include <memory>
#include <span>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

struct PlacedPyramid {
  std::shared_ptr<const FramePyramid> pyramid;
  Pose3 world_from_camera;
};

// The frame without the depth of what has moved since `earlier` (latest last, poses right to a few
// centimetres): where several saw a place, the latest one tells; what none tells of goes with what
// it hangs together with. What hides little of the frame is left in, which gives the same pyramid
// back. All pyramids of one camera and as many levels.
[[nodiscard]] std::shared_ptr<const FramePyramid> WithoutMoved(
    const PlacedPyramid& frame, std::span<const PlacedPyramid> earlier, const DepthNoise& noise);

// Two groups of frames, each placed rightly in itself. Of the surfaces that frames of one can tell
// frames of the other of (in view of them, not hidden behind what they see), the share that was
// seen through; the larger of both ways. Next to nothing where the groups are placed rightly and
// nothing has moved in between: real captures leave up to 1 %. At a wrong place much may agree, as
// walls and floors do in many places, but then something stands in what the others saw empty. 0
// where neither tells anything.
[[nodiscard]] double ContradictedShare(std::span<const PlacedPyramid> a,
                                       std::span<const PlacedPyramid> b,
                                       const DepthNoise& noise);

}  // namespace deepslam::alignment
