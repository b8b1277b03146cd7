// Depth of one camera seen from another, and images of one size brought to another.
#pragma once

#include "deepslam/core/image.h"
#include "deepslam/dataset/stored_frames.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::dataset {

// How many times smaller the colour images are made, each side: 1 when depth has their size;
// otherwise as often as leaves them at least as wide and high as depth and at least 640 px wide.
// Frames of a phone (1920 x 1440 colour, 256 x 192 depth) become 640 x 480.
[[nodiscard]] int ColourReduction(const CaptureCameras& cameras);

// The camera of the frames: colour's, reduced as above.
[[nodiscard]] PinholeCamera FrameCamera(const CaptureCameras& cameras);

// Means of factor x factor blocks; columns and rows that fill no block are left out.
[[nodiscard]] ColourImage ReduceColour(const ColourImage& colour, int factor);

// Depth of the frame camera from depth as it was measured, m, 0 invalid. Cameras that share their
// centre and axes: each pixel takes the inverse depth interpolated between its four neighbours
// (exact on planes) when all are valid and on one surface, else the nearest one's depth.
// Otherwise: the surface between neighbouring depth pixels is drawn into the target with a depth
// buffer, the nearest surface wins; what the depth camera did not see stays invalid. Neighbours
// belong to one surface unless that surface would be seen at more than 85 degrees.
[[nodiscard]] DepthImage RegisterDepth(const DepthImage& depth_m,
                                       const PinholeCamera& depth_camera,
                                       const Pose3& target_from_depth,
                                       const PinholeCamera& target);

}  // namespace deepslam::dataset
