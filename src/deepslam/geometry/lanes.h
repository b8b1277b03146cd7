// Sums over columns of single precision in lanes: one order of summation whatever the width of
// vectors, and added to double precision at the end.
#pragma once

#include <cstddef>

namespace deepslam {

// Partial sums of every sum.
inline constexpr std::size_t kLanes = 8;

// One number in each lane, computed on at once.
using Lanes [[gnu::vector_size(kLanes * sizeof(float)), gnu::may_alias]] = float;

// Columns are arrays of floats, aligned to 32 bytes, here and below; `k` is a multiple of kLanes.
template <typename Column>
const Lanes& LanesAt(const Column& x, std::size_t k) {
  return reinterpret_cast<const Lanes&>(x[k]);
}

inline double SumOf(const Lanes& lanes) {
  double sum = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) sum += static_cast<double>(lanes[lane]);
  return sum;
}

// sums[n] += sum of weight * x * y[n] up to `size`, a multiple of kLanes: all at once, so that none
// waits for its own last addition.
template <std::size_t kCount, typename Column>
void AddDots(
    const Column& weight, const Column& x, const Column* y, std::size_t size, double* sums) {
  Lanes lanes[kCount] = {};
  for (std::size_t k = 0; k < size; k += kLanes) {
    const Lanes weighted = LanesAt(weight, k) * LanesAt(x, k);
    for (std::size_t n = 0; n < kCount; ++n) lanes[n] += weighted * LanesAt(y[n], k);
  }
  for (std::size_t n = 0; n < kCount; ++n) sums[n] += SumOf(lanes[n]);
}

}  // namespace deepslam
