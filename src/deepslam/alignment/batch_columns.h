// Arrays of a batch of measurements, one for each quantity, and what is computed on them: sums,
// interpolation, small vectors of which the compiler keeps one number each in a vector's lanes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "deepslam/geometry/lanes.h"

namespace deepslam::alignment {

// Pairs are gathered and then computed on in batches, one array per quantity, so that the loops are
// vectorised; the arrays of a batch stay in the L1 cache.
inline constexpr std::size_t kBatch = 256;

struct alignas(32) Column : std::array<float, kBatch> {};
using IndexColumn = std::array<std::int32_t, kBatch>;

// `size` is a multiple of kLanes, here and below.
inline double Sum(const Column& x, std::size_t size) {
  Lanes lanes{};
  for (std::size_t k = 0; k < size; k += kLanes) lanes += LanesAt(x, k);
  return SumOf(lanes);
}

inline double Dot(const Column& x, const Column& y, std::size_t size) {
  Lanes lanes{};
  for (std::size_t k = 0; k < size; k += kLanes) lanes += LanesAt(x, k) * LanesAt(y, k);
  return SumOf(lanes);
}

// Weights of the four pixels round each point of a batch.
struct Bilinear {
  Column w00, w10, w01, w11;  // first the column's, then the row's pixel
  IndexColumn upper_left;     // pixels

  // Columns u and rows v of an image of this width, the last ones of it excluded.
  Bilinear(const Column& u, const Column& v, std::int32_t width, std::size_t size) {
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const std::int32_t u0 = static_cast<std::int32_t>(u[k]);
      const std::int32_t v0 = static_cast<std::int32_t>(v[k]);
      const float a = u[k] - static_cast<float>(u0), b = v[k] - static_cast<float>(v0);
      w00[k] = (1 - a) * (1 - b);
      w10[k] = a * (1 - b);
      w01[k] = (1 - a) * b;
      w11[k] = a * b;
      upper_left[k] = v0 * width + u0;
    }
  }
};

struct Triple {
  float x = 0, y = 0, z = 0;
};

struct Rotation {
  explicit Rotation(const Eigen::Matrix3f& m)
      : r00(m(0, 0)),
        r01(m(0, 1)),
        r02(m(0, 2)),
        r10(m(1, 0)),
        r11(m(1, 1)),
        r12(m(1, 2)),
        r20(m(2, 0)),
        r21(m(2, 1)),
        r22(m(2, 2)) {}
  Triple operator*(const Triple& p) const {
    return {r00 * p.x + r01 * p.y + r02 * p.z,
            r10 * p.x + r11 * p.y + r12 * p.z,
            r20 * p.x + r21 * p.y + r22 * p.z};
  }
  float r00, r01, r02, r10, r11, r12, r20, r21, r22;
};

}  // namespace deepslam::alignment
