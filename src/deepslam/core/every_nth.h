// A list thinned evenly.
#pragma once

#include <cstddef>
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

}  // namespace deepslam
