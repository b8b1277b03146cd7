// The rotation between two images of one camera, found from intensities alone: a start for frame
// alignment that survives fast turns, when the motion since the last frame is far beyond what ICP
// converges from.
#pragma once

#include <optional>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

// Exhaustive search over pan and tilt on the coarsest level by normalised correlation, then
// rotation-only photometric refinement. Nothing where there is no colour or no shift correlates.
[[nodiscard]] std::optional<Eigen::Quaterniond> SearchRotation(const FramePyramid& i,
                                                               const FramePyramid& j);

}  // namespace deepslam::alignment
