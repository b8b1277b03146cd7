// At what angle a depth image's rays meet the surface.
#pragma once

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"

namespace deepslam::fuse {

// Of each pixel the cosine between its ray and the surface's normal, from kMinIncidenceCosine to 1.
// 1 where the surface about the pixel is no plane: at edges, on things of few pixels, where depth
// is missing.
[[nodiscard]] Image<float> IncidenceCosines(const DepthImage& depth_m, const PinholeCamera& camera);

// 78 degrees: beyond, depth cameras see nothing.
inline constexpr float kMinIncidenceCosine = 0.2F;

}  // namespace deepslam::fuse
