// Depth images reduced by a whole factor: each block of pixels becomes the mean of what lies on the
// surface of its median one, so that no depth is made up between two surfaces.
#pragma once

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/core/unfilled.h"
#include "deepslam/frames/stored_depth.h"
#include "deepslam/geometry/camera.h"

namespace deepslam::alignment {

// Of depth as it is stored, to the size of `reduced`; depth out of the options' range and NaN are
// invalid, 0 in the result. `noise_scale` times the options' noise tells surfaces apart.
[[nodiscard]] UnfilledVector<float> ReduceDepth(const StoredDepth& depth,
                                                const PinholeCamera& reduced,
                                                int factor,
                                                const PyramidOptions& options,
                                                double noise_scale);

// Of a level, to half its width and height.
[[nodiscard]] UnfilledVector<float> HalveDepth(const PyramidLevel& fine,
                                               const PinholeCamera& reduced,
                                               const PyramidOptions& options,
                                               double noise_scale);

}  // namespace deepslam::alignment
