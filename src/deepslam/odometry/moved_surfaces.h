// What has moved between frames: people, doors, chairs that are pushed.
//
// A surface that stands where an earlier frame saw through to something behind cannot have stood
// there then. The rule needs no motion of its own to be told apart from the camera's, and says
// nothing of what merely comes out from behind something.
#pragma once

#include <memory>
#include <span>

#include "deepslam/geometry/pose.h"
#include "deepslam/odometry/image_pyramid.h"

namespace deepslam::odometry {

struct PlacedPyramid {
  std::shared_ptr<const FramePyramid> pyramid;
  Pose3 world_from_camera;
};

// The frame without the depth of what has moved since `earlier` (latest last, poses right to a few
// centimetres): where several saw a place, the latest one tells. What hides little of the frame is
// left in, which gives the same pyramid back. All pyramids of one camera and as many levels.
[[nodiscard]] std::shared_ptr<const FramePyramid> WithoutMoved(
    const PlacedPyramid& frame, std::span<const PlacedPyramid> earlier, const DepthNoise& noise);

}  // namespace deepslam::odometry
