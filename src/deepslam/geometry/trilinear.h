// Trilinear interpolation in a dense field, with its gradient.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

namespace deepslam {

struct TrilinearSample {
  float value = 0;
  Eigen::Vector3f gradient = Eigen::Vector3f::Zero();  // per cell
};

// The same in numbers of which the compiler keeps one each in a vector's lanes.
struct TrilinearLane {
  float value = 0;
  float dx = 0, dy = 0, dz = 0;  // per cell
};

// `c` holds the corners' values, that at (x, y, z) at 4 x + 2 y + z. `tx`, `ty`, `tz` in [0, 1]
// from the first corner to the opposite one.
inline TrilinearLane MixCorners(const std::array<float, 8>& c, float tx, float ty, float tz) {
  const auto mix = [](float a, float b, float w) { return a + w * (b - a); };
  const float c00 = mix(c[0], c[1], tz);
  const float c01 = mix(c[2], c[3], tz);
  const float c10 = mix(c[4], c[5], tz);
  const float c11 = mix(c[6], c[7], tz);
  const float low = mix(c00, c01, ty);
  const float high = mix(c10, c11, ty);
  const float dz = mix(mix(c[1] - c[0], c[3] - c[2], ty), mix(c[5] - c[4], c[7] - c[6], ty), tx);
  return {mix(low, high, tx), high - low, mix(c01 - c00, c11 - c10, tx), dz};
}

// `corner` points at the cell's first corner; neighbours along x, y and z lie `stride_x`,
// `stride_y` and 1 further on.
inline TrilinearSample SampleTrilinear(const float* corner,
                                       std::size_t stride_x,
                                       std::size_t stride_y,
                                       const Eigen::Array3f& t) {
  const float* const c = corner;
  const std::size_t x = stride_x;
  const std::size_t y = stride_y;
  const TrilinearLane sample = MixCorners(
      {c[0], c[1], c[y], c[y + 1], c[x], c[x + 1], c[x + y], c[x + y + 1]}, t.x(), t.y(), t.z());
  return {sample.value, {sample.dx, sample.dy, sample.dz}};
}

}  // namespace deepslam
