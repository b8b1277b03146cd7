// An alignment to its end, for what is built on it: frames are placed to a twentieth of a pixel of
// the finest level, which is less than their noise, but leans towards where the camera was expected.
#pragma once

#include "deepslam/odometry/frame_alignment.h"

namespace deepslam::odometry {

// Of `found`, an outcome of AlignPyramids for the same frames. It stays as it is where it is not ok
// or has a direction of its start, and where its end is not ok.
[[nodiscard]] FrameAlignment Sharpened(const FrameAlignment& found,
                                       const FramePyramid& i,
                                       const FramePyramid& j,
                                       const AlignmentOptions& options);

}  // namespace deepslam::odometry
