#include "deepslam/fuse/incidence.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "deepslam/core/parallel.h"

namespace deepslam::fuse {
namespace {

// Between a pixel and the neighbours that tell its slope, as an angle: 1 cm at a metre, 5 px of a
// Kinect.
constexpr double kStep_rad = 0.01;
// On a plane inverse depth is linear in the pixel. A Kinect's deviates by 0.0015 1/m at any depth,
// the second difference of three pixels by 0.004; at edges it is larger than this.
constexpr float kMaxBend_per_m = 0.015F;

// 1 / m; 0 where nothing was measured.
Image<float> InverseDepth(const DepthImage& depth_m) {
  Image<float> inverse(depth_m.width(), depth_m.height());
  for (int v = 0; v < depth_m.height(); ++v) {
    const float* const from = depth_m.row(v);
    float* const to = inverse.row(v);
    for (int u = 0; u < depth_m.width(); ++u) to[u] = from[u] > 0 ? 1.0F / from[u] : 0.0F;
  }
  return inverse;
}

}  // namespace

// A plane n . p = d has the inverse depth w = (n . r) / d along the ray r of depth 1, whose slopes
// in the ray's x and y are n_x / d and n_y / d; the cosine is w / (|n / d| |r|).
Image<float> IncidenceCosines(const DepthImage& depth_m, const PinholeCamera& camera) {
  const int step = std::max(1, static_cast<int>(std::lround(kStep_rad * camera.fx)));
  const Image<float> inverse = InverseDepth(depth_m);
  Image<float> cosines(depth_m.width(), depth_m.height(), 1.0F);
  if (depth_m.width() <= 2 * step || depth_m.height() <= 2 * step) return cosines;
  std::vector<float> rays_x(static_cast<std::size_t>(depth_m.width()));
  for (int u = 0; u < depth_m.width(); ++u)
    rays_x[static_cast<std::size_t>(u)] = static_cast<float>((u - camera.cx) / camera.fx);
  const auto slope_x = static_cast<float>(camera.fx / (2 * step));
  const auto slope_y = static_cast<float>(camera.fy / (2 * step));
  ParallelFor(static_cast<std::size_t>(depth_m.height() - 2 * step), [&](std::size_t row) {
    const int v = static_cast<int>(row) + step;
    const float* const here = inverse.row(v);
    const float* const above = inverse.row(v - step);
    const float* const below = inverse.row(v + step);
    float* const out = cosines.row(v);
    const auto ray_y = static_cast<float>((v - camera.cy) / camera.fy);
    for (int u = step; u < depth_m.width() - step; ++u) {
      const float w = here[u];
      const float left = here[u - step];
      const float right = here[u + step];
      const float ray_x = rays_x[static_cast<std::size_t>(u)];
      const float x = (right - left) * slope_x;
      const float y = (below[u] - above[u]) * slope_y;
      const float z = w - ray_x * x - ray_y * y;
      const float cosine =
          w / std::sqrt((x * x + y * y + z * z) * (ray_x * ray_x + ray_y * ray_y + 1.0F));
      const bool is_plane = (w > 0) & (left > 0) & (right > 0) & (above[u] > 0) & (below[u] > 0) &
                            (std::abs(left + right - 2 * w) < kMaxBend_per_m) &
                            (std::abs(above[u] + below[u] - 2 * w) < kMaxBend_per_m);
      out[u] = is_plane ? std::max(kMinIncidenceCosine, std::min(1.0F, cosine)) : 1.0F;
    }
  });
  return cosines;
}

}  // namespace deepslam::fuse
