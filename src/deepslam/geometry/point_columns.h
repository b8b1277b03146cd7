// Points in batches, one array for each quantity, so that loops over them are vectorised; the
// arrays of a batch stay in the L1 cache.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

namespace deepslam {

// Points: a dozen columns stay in the first-level cache.
inline constexpr std::size_t kPointBatch = 128;
// Partial sums of every sum: one order of summation whatever the width of vectors.
inline constexpr std::size_t kPointLanes = 8;

struct alignas(32) PointColumn : std::array<float, kPointBatch> {};

struct VectorColumns {
  PointColumn x, y, z;
  void Set(std::size_t k, float to_x, float to_y, float to_z) {
    x[k] = to_x;
    y[k] = to_y;
    z[k] = to_z;
  }
};

// The first multiple of kPointLanes that holds `size` points.
constexpr std::size_t WholeLanes(std::size_t size) {
  return (size + kPointLanes - 1) / kPointLanes * kPointLanes;
}

// Three numbers, and what is done to them, of which the compiler keeps one each in a vector's
// lanes.
struct Triple {
  float x = 0, y = 0, z = 0;
  friend Triple operator-(const Triple& a, const Triple& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend Triple operator*(float factor, const Triple& a) {
    return {factor * a.x, factor * a.y, factor * a.z};
  }
};
inline float Dot(const Triple& a, const Triple& b) { return a.x * b.x + (a.y * b.y + a.z * b.z); }
inline Triple TripleAt(const VectorColumns& columns, std::size_t k) {
  return {columns.x[k], columns.y[k], columns.z[k]};
}

struct LinearMap {
  explicit LinearMap(const Eigen::Matrix3f& m)
      : x_row{m(0, 0), m(0, 1), m(0, 2)},
        y_row{m(1, 0), m(1, 1), m(1, 2)},
        z_row{m(2, 0), m(2, 1), m(2, 2)} {}
  Triple operator*(const Triple& a) const { return {Dot(x_row, a), Dot(y_row, a), Dot(z_row, a)}; }
  Triple x_row, y_row, z_row;
};

struct AffineMap {
  AffineMap(const Eigen::Matrix3f& linear_part, const Eigen::Vector3f& translation)
      : linear(linear_part), offset{translation.x(), translation.y(), translation.z()} {}
  Triple operator*(const Triple& a) const {
    const Triple turned = linear * a;
    return {turned.x + offset.x, turned.y + offset.y, turned.z + offset.z};
  }
  LinearMap linear;
  Triple offset;
};

}  // namespace deepslam
