// The support plane of a thing, told by the heights of its points.
#pragma once

#include <span>

namespace deepslam {

// The layer of that thickness that holds most of the heights, the lowest of equals. `heights_m`
// ascend; empty if these are.
[[nodiscard]] std::span<const double> FullestLayer(std::span<const double> heights_m,
                                                   double layer_m);

// The same, or the highest of several that hold half as many: a top and the boards under it.
[[nodiscard]] std::span<const double> TopLayer(std::span<const double> heights_m, double layer_m);

}  // namespace deepslam
