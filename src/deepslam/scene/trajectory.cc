#include "deepslam/scene/trajectory.h"

#include <algorithm>

#include "deepslam/scene/edge_store.h"

namespace deepslam {

std::size_t Odometry::num_edges() const {
  return edges.size() + (more_edges ? more_edges->size() : 0);
}

void Odometry::ForEachEdge(const std::function<void(const RelativePose&)>& use) const {
  std::ranges::for_each(edges, use);
  if (more_edges) ForEach(*more_edges, use);
}

}  // namespace deepslam
