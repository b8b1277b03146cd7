// What hangs together, told pair by pair.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace deepslam {

// Sets of the numbers below `size`, each by itself at first; a set is known by its least member.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }

  [[nodiscard]] std::uint32_t LeastOf(std::uint32_t x) {
    while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
    return x;
  }
  // Whether the two were in different sets until now.
  bool Join(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t least_a = LeastOf(a);
    const std::uint32_t least_b = LeastOf(b);
    parent_[std::max(least_a, least_b)] = std::min(least_a, least_b);
    return least_a != least_b;
  }

  [[nodiscard]] std::vector<std::uint32_t> LeastOfEach() {
    for (std::uint32_t x = 0; x < parent_.size(); ++x) parent_[x] = LeastOf(x);
    return parent_;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace deepslam
