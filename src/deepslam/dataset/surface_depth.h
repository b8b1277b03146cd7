// Depth between the pixels of a depth image: what neighbouring pixels of one surface say together.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"

namespace deepslam::dataset {

// Largest ratio of depths of two neighbouring pixels of one surface, diagonal ones included: seen
// at the angle a from its normal, depth changes by tan(a) / f of itself from pixel to pixel.
// Surfaces seen at more than 85 degrees are taken for several.
[[nodiscard]] inline float MaxDepthRatio(const PinholeCamera& camera) {
  constexpr double kMaxSlantTan = 11.43;  // of 85 degrees
  return static_cast<float>(1.0 + 1.5 * kMaxSlantTan / std::min(camera.fx, camera.fy));
}

[[nodiscard]] inline bool OneSurface(const std::array<float, 4>& depth_m, float max_ratio) {
  const auto [low, high] = std::minmax_element(depth_m.begin(), depth_m.end());
  return *low > 0 && *high <= max_ratio * *low;
}

// Of the four neighbours (upper left, upper right, lower left, lower right) at the shares of the
// right and of the lower ones, which are of one surface.
[[nodiscard]] inline float BetweenOnPlane(const std::array<float, 4>& depth_m,
                                          double share_u,
                                          double share_v) {
  const double upper =
      (1 - share_u) / static_cast<double>(depth_m[0]) + share_u / static_cast<double>(depth_m[1]);
  const double lower =
      (1 - share_u) / static_cast<double>(depth_m[2]) + share_u / static_cast<double>(depth_m[3]);
  return static_cast<float>(1.0 / ((1 - share_v) * upper + share_v * lower));
}

}  // namespace deepslam::dataset
