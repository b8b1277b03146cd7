// Frames of a capture read for alignment: no more of their colour than its brightness, at the size
// that is worked on.
#pragma once

#include "deepslam/core/ids.h"
#include "deepslam/core/result.h"
#include "deepslam/odometry/image_pyramid.h"
#include "deepslam/scene/frame_source.h"

namespace deepslam::odometry {

struct ReadFrame {
  FramePyramid pyramid;  // never empty
  StoredDepth depth;     // what it was made of
};

// An error where the frame cannot be read or its depth has not the camera's size.
[[nodiscard]] Result<ReadFrame> ReadPyramid(const FrameSource& frames,
                                            FrameIdx frame,
                                            const PyramidOptions& options);

}  // namespace deepslam::odometry
