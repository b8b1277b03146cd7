#include "deepslam/odometry/sharpened_alignment.h"

namespace deepslam::odometry {

FrameAlignment Sharpened(const FrameAlignment& found,
                         const FramePyramid& i,
                         const FramePyramid& j,
                         const AlignmentOptions& options) {
  if (!found.ok || found.held) return found;
  const FrameAlignment sharpened = RefineAlignment(i, j, found.i_from_j, options);
  return sharpened.ok ? sharpened : found;
}

}  // namespace deepslam::odometry
