// Whether two placed frames show the same details of what they both see: patch-wise zero-mean
// normalised cross-correlation (ZNCC) of their intensities.
//
// Two tables over two floors correlate by their one contrast, light over dark, whatever the floors
// are made of. Within patches that are smaller than furniture such contrasts are few, and boards do
// not look like tiles.
#pragma once

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

// Correlation of intensities about the means of small patches, each as large a part as it has
// points of one that lie on surfaces of the other; the smaller of both ways. 1 without colour, and
// where neither shows any details; near 0 where one alone does. Pyramids of one camera and as many
// levels.
[[nodiscard]] double PatchZncc(const FramePyramid& i,
                               const FramePyramid& j,
                               const Pose3& i_from_j,
                               const DepthNoise& noise);

}  // namespace deepslam::alignment
