// A layout carried along with the cameras that saw it.
#pragma once

#include <vector>

#include "deepslam/geometry/pose.h"
#include "deepslam/scene/layout.h"

namespace deepslam::layout {

// Where a camera was when the layout was read, and where it is now.
struct MovedCamera {
  Pose3 level_from_camera;  // in the layout's world
  Pose3 world_from_camera;
};

// The layout in the world of the moved cameras, z up in both. Each place moves as the cameras near
// it did, the nearest most; openings stay in their walls. `level_from_tracking` is of no use then
// and becomes the identity. Without cameras the layout stays where it is.
[[nodiscard]] Layout CarryLayout(Layout layout, const std::vector<MovedCamera>& cameras);

}  // namespace deepslam::layout
