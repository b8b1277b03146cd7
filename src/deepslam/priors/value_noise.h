// Smooth noise in [0, 1] with features of unit size, quick rather than fine.
#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Core>

namespace deepslam::priors {

inline float LatticeValue(int x, int y, int z) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 374761393U +
                    static_cast<std::uint32_t>(y) * 668265263U +
                    static_cast<std::uint32_t>(z) * 2246822519U;
  h = (h ^ (h >> 13U)) * 1274126177U;
  return static_cast<float>((h ^ (h >> 16U)) & 0xFFFFU) / 65535.0F;
}

inline float ValueNoise(const Eigen::Vector3f& p) {
  const Eigen::Vector3f floor = p.array().floor();
  const Eigen::Vector3f f = p - floor;
  const Eigen::Vector3i at = floor.cast<int>();
  float sum = 0;
  for (int n = 0; n < 8; ++n) {
    const int a = n & 1;
    const int b = n >> 1 & 1;
    const int c = n >> 2;
    sum += LatticeValue(at.x() + a, at.y() + b, at.z() + c) * (a != 0 ? f.x() : 1 - f.x()) *
           (b != 0 ? f.y() : 1 - f.y()) * (c != 0 ? f.z() : 1 - f.z());
  }
  return sum;
}

}  // namespace deepslam::priors
