// Arrays of a batch of measurements, one for each quantity, and sums over them.
#pragma once

#include <array>
#include <cstddef>

namespace deepslam::odometry {

// Pairs are gathered and then computed on in batches, one array per quantity, so that the loops are
// vectorised; the arrays of a batch stay in the L1 cache.
inline constexpr std::size_t kBatch = 256;
inline constexpr std::size_t kLanes =
    8;  // partial sums per entry: one order of summation whatever the vector width

struct alignas(32) Column : std::array<float, kBatch> {};

// One number in each lane, computed on at once.
using Lanes [[gnu::vector_size(kLanes * sizeof(float)), gnu::may_alias]] = float;

inline const Lanes& LanesAt(const Column& x, std::size_t k) {
  return reinterpret_cast<const Lanes&>(x[k]);
}

inline double SumOf(const Lanes& lanes) {
  double sum = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) sum += static_cast<double>(lanes[lane]);
  return sum;
}

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

// sums[n] += sum of weight * x * y[n]: all at once, so that none waits for its own last addition.
template <std::size_t kCount>
void AddDots(
    const Column& weight, const Column& x, const Column* y, std::size_t size, double* sums) {
  Lanes lanes[kCount] = {};
  for (std::size_t k = 0; k < size; k += kLanes) {
    const Lanes weighted = LanesAt(weight, k) * LanesAt(x, k);
    for (std::size_t n = 0; n < kCount; ++n) lanes[n] += weighted * LanesAt(y[n], k);
  }
  for (std::size_t n = 0; n < kCount; ++n) sums[n] += SumOf(lanes[n]);
}

}  // namespace deepslam::odometry
