// Draws for designs, and the sides they are made for.
#pragma once

#include <array>
#include <cstddef>

#include "deepslam/core/random.h"

namespace deepslam::furniture {

// What comes in pairs: right and left, behind and in front.
inline constexpr std::array<double, 2> kSides = {-1.0, 1.0};

inline bool Chance(Random& random, double probability) { return random.Uniform() < probability; }

// Index by weight; the weights need not sum to one.
template <std::size_t N>
std::size_t Pick(Random& random, const std::array<double, N>& weights) {
  double sum = 0;
  for (const double weight : weights) sum += weight;
  double at = random.Uniform(0, sum);
  for (std::size_t n = 0; n < N; ++n) {
    at -= weights[n];
    if (at < 0) return n;
  }
  return N - 1;
}

inline int Count(Random& random, int low, int high) {
  return low + static_cast<int>(random.Index(static_cast<std::uint64_t>(high - low + 1)));
}

}  // namespace deepslam::furniture
