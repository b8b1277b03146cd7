#include "deepslam/mapping/edge_store.h"

#include <algorithm>

#include "deepslam/core/check.h"

namespace deepslam::mapping {

Status AddAll(std::span<const RelativePose> edges, EdgeStore& store) {
  for (const RelativePose& edge : edges) {
    if (Status status = store.Add(edge); !status.ok()) return status;
  }
  return Ok();
}

Status MemoryEdgeStore::Add(const RelativePose& edge) {
  edges_.push_back(edge);
  return Ok();
}

void MemoryEdgeStore::Read(std::size_t first, std::span<RelativePose> edges) const {
  DEEPSLAM_CHECK(first + edges.size() <= edges_.size(), "edges that are there");
  std::ranges::copy(std::span(edges_).subspan(first, edges.size()), edges.begin());
}

}  // namespace deepslam::mapping
