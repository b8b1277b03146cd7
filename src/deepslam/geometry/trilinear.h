// Trilinear interpolation in a dense field, with its gradient.
#pragma once

#include <cstddef>

#include <Eigen/Core>

namespace deepslam {

struct TrilinearSample {
  float value = 0;
  Eigen::Vector3f gradient = Eigen::Vector3f::Zero();  // per cell
};

// `corner` points at the cell's first corner; neighbours along x, y and z lie `stride_x`,
// `stride_y` and 1 further on. `t` in [0, 1] from the first corner to the opposite one.
inline TrilinearSample SampleTrilinear(const float* corner,
                                       std::size_t stride_x,
                                       std::size_t stride_y,
                                       const Eigen::Array3f& t) {
  const float* const c = corner;
  const std::size_t x = stride_x;
  const std::size_t y = stride_y;
  const auto mix = [](float a, float b, float w) { return a + w * (b - a); };
  const float c00 = mix(c[0], c[1], t.z());
  const float c01 = mix(c[y], c[y + 1], t.z());
  const float c10 = mix(c[x], c[x + 1], t.z());
  const float c11 = mix(c[x + y], c[x + y + 1], t.z());
  const float low = mix(c00, c01, t.y());
  const float high = mix(c10, c11, t.y());
  const float dz = mix(mix(c[1] - c[0], c[y + 1] - c[y], t.y()),
                       mix(c[x + 1] - c[x], c[x + y + 1] - c[x + y], t.y()),
                       t.x());
  return {mix(low, high, t.x()), Eigen::Vector3f(high - low, mix(c01 - c00, c11 - c10, t.x()), dz)};
}

}  // namespace deepslam
