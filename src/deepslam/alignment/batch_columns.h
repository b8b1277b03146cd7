// Arrays of a batch of measurements, one for each quantity, and sums over them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

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

}  // namespace deepslam::alignment
