// Lists thinned evenly: to a share of them, or to so many.
#pragma once

#include <algorithm>
#include <cstddef>
#include <ranges>
#include <vector>

namespace deepslam {

// Every `step`-th of a list (>= 1), from the first on, in a list of its own size: one that shrinks
// in place would keep its memory.
template <typename T>
[[nodiscard]] std::vector<T> EveryNth(const std::vector<T>& all, std::size_t step) {
  std::vector<T> some;
  some.reserve((all.size() + step - 1) / step);
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

// `count` of a list, spread evenly over it from the first on; all of one that has no more.
template <std::ranges::random_access_range List>
[[nodiscard]] std::vector<std::ranges::range_value_t<List>> EvenlySpaced(const List& all,
                                                                         std::size_t count) {
  const std::size_t size = std::ranges::size(all);
  const std::size_t num_chosen = std::min(count, size);
  std::vector<std::ranges::range_value_t<List>> chosen;
  chosen.reserve(num_chosen);
  for (std::size_t n = 0; n < num_chosen; ++n) chosen.push_back(all[n * size / num_chosen]);
  return chosen;
}

}  // namespace deepslam
