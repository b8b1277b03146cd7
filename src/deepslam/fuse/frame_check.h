// What can be fused.
#pragma once

#include "deepslam/core/result.h"
#include "deepslam/frames/frame.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::fuse {

// InvalidInput for a depth image that is empty or of another size than the camera's, a colour image
// of another size than that (an empty one passes), a camera or pose that is not finite, and places
// so far off that blocks could not be counted.
[[nodiscard]] Status CheckFrame(const Frame& frame,
                                const PinholeCamera& camera,
                                const Pose3& world_from_camera);

}  // namespace deepslam::fuse
