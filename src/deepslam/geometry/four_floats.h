// Four numbers of a pixel or point at once, and four of them turned into a column of each number.
#pragma once

#include <cstddef>
#include <cstring>

namespace deepslam {

using FourFloats [[gnu::vector_size(4 * sizeof(float))]] = float;

// By bytes: they may lie anywhere.
inline FourFloats FourFrom(const float* first) {
  FourFloats four;
  std::memcpy(&four, first, sizeof(four));
  return four;
}
inline void WriteFour(const FourFloats& four, float* first) {
  std::memcpy(first, &four, sizeof(four));
}

struct FourByFour {
  FourFloats a, b, c, d;
};

inline FourByFour Transposed(const FourByFour& rows) {
  const auto& [a, b, c, d] = rows;
  const FourFloats ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5);
  const FourFloats cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const FourFloats ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const FourFloats cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  return {__builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5),
          __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7),
          __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5),
          __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7)};
}

template <typename Point>
FourByFour FourOf(const Point& point, std::size_t k) {
  return {point(k), point(k + 1), point(k + 2), point(k + 3)};
}

// The first three numbers of four points, to where their columns go on; gives the fourth ones.
inline FourFloats ToColumns(const FourByFour& points, float* x, float* y, float* z) {
  const FourByFour columns = Transposed(points);
  WriteFour(columns.a, x);
  WriteFour(columns.b, y);
  WriteFour(columns.c, z);
  return columns.d;
}

}  // namespace deepslam
