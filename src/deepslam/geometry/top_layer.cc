#include "deepslam/geometry/top_layer.h"

#include <algorithm>
#include <cstddef>

namespace deepslam {
namespace {

std::span<const double> Above(double height_m, std::span<const double> heights_m) {
  const auto first = std::ranges::upper_bound(heights_m, height_m);
  return heights_m.subspan(static_cast<std::size_t>(first - heights_m.begin()));
}

}  // namespace

std::span<const double> FullestLayer(std::span<const double> heights_m, double layer_m) {
  std::span<const double> fullest;
  for (std::size_t low = 0, high = 0; low < heights_m.size(); ++low) {
    while (high < heights_m.size() && heights_m[high] < heights_m[low] + layer_m) ++high;
    if (high - low > fullest.size()) fullest = heights_m.subspan(low, high - low);
  }
  return fullest;
}

std::span<const double> TopLayer(std::span<const double> heights_m, double layer_m) {
  const std::span<const double> fullest = FullestLayer(heights_m, layer_m);
  std::span<const double> top = fullest;
  while (!top.empty()) {
    // Half a layer apart, so that the scatter of one is no layer above it.
    const std::span<const double> higher =
        FullestLayer(Above(top.back() + 0.5 * layer_m, heights_m), layer_m);
    if (higher.empty() || 2 * higher.size() < fullest.size()) break;
    top = higher;
  }
  return top;
}

}  // namespace deepslam
