#include "deepslam/scene/trajectory.h"

#include <algorithm>

namespace deepslam {

void ForEach(const ShelvedEdges& edges, const std::function<void(const RelativePose&)>& use) {
  constexpr std::size_t kAtOnce = 256;  // 64 KB
  std::vector<RelativePose> some;
  for (std::size_t first = 0; first < edges.size(); first += some.size()) {
    some.resize(std::min(kAtOnce, edges.size() - first));
    edges.Read(first, some);
    std::ranges::for_each(some, use);
  }
}

void Odometry::ForEachEdge(const std::function<void(const RelativePose&)>& use) const {
  std::ranges::for_each(edges, use);
  if (more_edges) ForEach(*more_edges, use);
}

}  // namespace deepslam
