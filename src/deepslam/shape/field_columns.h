// A distance field over the cube [-0.5, 0.5]^3, asked for points in batches: trilinear between the
// centres of its cells, and beyond the outermost of them by the distance to the surface point
// nearest to the field's rim.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "deepslam/geometry/point_columns.h"
#include "deepslam/geometry/trilinear.h"

namespace deepslam::shape {

struct FieldSample {
  float distance;
  Triple gradient;  // about unit length
};

struct FieldSampleColumns {
  PointColumn distance;
  VectorColumns gradient;
};

// Of a point beyond the field, from the sample at the place `inside` that is nearest to it.
inline FieldSample BeyondField(const Triple& inside, const FieldSample& sample, const Triple& p) {
  const float length = std::sqrt(Dot(sample.gradient, sample.gradient));
  const float per_length = sample.distance / (length > 1e-6F ? length : 1e-6F);
  const Triple away = p - (inside - per_length * sample.gradient);
  const float distance = std::sqrt(Dot(away, away));
  const float divisor = distance > 0 ? distance : 1.0F;
  return {distance, {away.x / divisor, away.y / divisor, away.z / divisor}};
}

// The first `size` points of a batch, all of them finite, against a field of kSide cells along each
// axis, index order of VoxelGrid. Here, for its callers' loops, which are compiled for wide
// vectors.
template <int kSide>
void SampleField(const float* field,
                 const VectorColumns& points,
                 std::size_t size,
                 FieldSampleColumns& samples) {
  constexpr auto kCells = static_cast<float>(kSide);
  constexpr float kRim = 0.5F - 0.5F / kCells;  // centres of the outermost cells
  constexpr std::size_t kRow = kSide, kLayer = kRow * kRow;
  const auto within = [](float coordinate) {
    const float above = coordinate > -kRim ? coordinate : -kRim;
    return above < kRim ? above : kRim;
  };
  VectorColumns inside, t;
  std::array<std::int32_t, kPointBatch> corner;
  std::array<PointColumn, 8> corners;
#pragma GCC ivdep
  for (std::size_t k = 0; k < size; ++k) {
    const float x = within(points.x[k]);
    const float y = within(points.y[k]);
    const float z = within(points.z[k]);
    inside.Set(k, x, y, z);
    // Rounded down by the cast, as nothing inside is negative by more than rounding.
    const float i = (x + 0.5F) * kCells - 0.5F;
    const float j = (y + 0.5F) * kCells - 0.5F;
    const float l = (z + 0.5F) * kCells - 0.5F;
    const auto base = [](float cell) {
      const auto truncated = static_cast<std::int32_t>(cell);
      return truncated < kSide - 2 ? truncated : kSide - 2;
    };
    t.Set(k,
          i - static_cast<float>(base(i)),
          j - static_cast<float>(base(j)),
          l - static_cast<float>(base(l)));
    corner[k] = (base(i) * kSide + base(j)) * kSide + base(l);
  }
  for (std::size_t k = 0; k < size; ++k) {
    const float* const c = field + corner[k];
    corners[0][k] = c[0];
    corners[1][k] = c[1];
    corners[2][k] = c[kRow];
    corners[3][k] = c[kRow + 1];
    corners[4][k] = c[kLayer];
    corners[5][k] = c[kLayer + 1];
    corners[6][k] = c[kLayer + kRow];
    corners[7][k] = c[kLayer + kRow + 1];
  }
#pragma GCC ivdep
  for (std::size_t k = 0; k < size; ++k) {
    const TrilinearLane mixed = MixCorners({corners[0][k],
                                            corners[1][k],
                                            corners[2][k],
                                            corners[3][k],
                                            corners[4][k],
                                            corners[5][k],
                                            corners[6][k],
                                            corners[7][k]},
                                           t.x[k],
                                           t.y[k],
                                           t.z[k]);
    const FieldSample here = {mixed.value, kCells * Triple{mixed.dx, mixed.dy, mixed.dz}};
    const Triple rim = TripleAt(inside, k);
    const Triple p = TripleAt(points, k);
    const FieldSample beyond = BeyondField(rim, here, p);
    const bool is_inside = (rim.x == p.x) & (rim.y == p.y) & (rim.z == p.z);
    samples.distance[k] = is_inside ? here.distance : beyond.distance;
    samples.gradient.Set(k,
                         is_inside ? here.gradient.x : beyond.gradient.x,
                         is_inside ? here.gradient.y : beyond.gradient.y,
                         is_inside ? here.gradient.z : beyond.gradient.z);
  }
}

}  // namespace deepslam::shape
