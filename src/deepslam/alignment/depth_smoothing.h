// Edge-respecting smoothing of depth.
#pragma once

#include "deepslam/core/unfilled.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/depth_noise.h"

namespace deepslam::alignment {

// Of the window at noise scale 1: 5 x 5 pixels.
inline constexpr int kSmoothingRadius = 2;

// Weighted mean over a window of what lies on the same surface (a bilateral filter with the depth
// noise as range), along rows and then along columns (Pham and van Vliet 2005). The slope of white
// noise smoothed over a window falls with the window's area, so an area in proportion to the noise
// keeps the normals as good as they are at scale 1.
// Depth row by row as the camera has it; 0 is invalid, stays so, and pulls nothing.
[[nodiscard]] UnfilledVector<float> SmoothDepth(const UnfilledVector<float>& depth_m,
                                                const PinholeCamera& camera,
                                                const DepthNoise& model,
                                                double noise_scale);

}  // namespace deepslam::alignment
