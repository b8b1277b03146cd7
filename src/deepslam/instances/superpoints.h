// Over-segmentation of a surface into superpoints: parts so smooth that no two things share one.
//
// Graph-based segmentation (Felzenszwalb, Huttenlocher 2004) over the surface's elements, as the
// annotations of ScanNet were prepared (Dai et al. 2017). An edge costs what the normals of its
// ends differ by; where the surface is convex half of that, since things are convex where they end
// in themselves and concave where they touch others (Stein et al. 2014, LCCP).
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/instances/surface_elements.h"

namespace deepslam::instances {

struct SuperpointOptions {
  double threshold = 0.6;  // k of Felzenszwalb and Huttenlocher; larger: larger superpoints
  double convex_cost = 0.5;
  int min_elements = 12;  // smaller superpoints join the neighbour that is most like them
};
void Describe(OptionsVisitor& visitor, SuperpointOptions& options);

struct Superpoints {
  std::vector<int> of_element;    // -1: part of the room's structure
  std::vector<int> num_elements;  // of each superpoint

  [[nodiscard]] int count() const { return static_cast<int>(num_elements.size()); }
};

// How the surface goes on between two elements: 1 - cos of the angle between their normals.
[[nodiscard]] double NormalDifference(const SurfaceElements& elements, const ElementPair& pair);
// Convex as seen from the free side, or as good as flat.
[[nodiscard]] bool IsConvex(const SurfaceElements& elements, const ElementPair& pair);

// Numbered in the order of their first elements. `is_structure`: of each element. `pairs` join
// neighbouring elements.
[[nodiscard]] Superpoints MakeSuperpoints(const SurfaceElements& elements,
                                          std::span<const char> is_structure,
                                          std::span<const ElementPair> pairs,
                                          const SuperpointOptions& options);

}  // namespace deepslam::instances
