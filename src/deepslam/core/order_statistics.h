// Order statistics of noisy values in a vector or span. All reorder the values, which are not
// empty, and none is between two values: the median of an even number is the upper one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>

namespace deepslam {

// The value that stands at `rank` (below their number) when they are sorted.
template <typename Values>
[[nodiscard]] auto OrderStatistic(Values& values, std::size_t rank) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

// The value that this share of them, [0, 1], is below, to the nearest rank.
template <typename Values>
[[nodiscard]] auto Quantile(Values& values, double share) {
  return OrderStatistic(
      values, static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5));
}

template <typename Values>
[[nodiscard]] auto Median(Values& values) {
  return OrderStatistic(values, values.size() / 2);
}

// Least and greatest value, one part in `parts` (> 2) left out at either end.
template <typename Values>
[[nodiscard]] auto InnerRange(Values& values, std::size_t parts) {
  const std::size_t cut = values.size() / parts;
  const auto low = OrderStatistic(values, cut);
  return std::pair(low, OrderStatistic(values, values.size() - 1 - cut));
}

}  // namespace deepslam
