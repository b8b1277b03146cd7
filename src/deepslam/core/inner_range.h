// Extents of noisy points.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace deepslam {

// Least and greatest value, one part in `parts` (> 2) left out at either end. Reorders the values,
// which are not empty.
[[nodiscard]] inline std::pair<double, double> InnerRange(std::vector<double>& values,
                                                          std::size_t parts) {
  const auto cut = static_cast<std::ptrdiff_t>(values.size() / parts);
  std::nth_element(values.begin(), values.begin() + cut, values.end());
  const double low = values[static_cast<std::size_t>(cut)];
  std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
  return {low, *(values.end() - 1 - cut)};
}

}  // namespace deepslam
