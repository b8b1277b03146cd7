#include "deepslam/scene/edge_store.h"

#include <algorithm>

#include "deepslam/core/check.h"

namespace deepslam {

Status AddAll(std::span<const RelativePose> edges, EdgeStore& store) {
  for (const RelativePose& edge : edges) {
    if (Status status = store.Add(edge); !status.ok()) return status;
  }
  return Ok();
}

void ForEach(const EdgeStore& edges, const std::function<void(const RelativePose&)>& use) {
  constexpr std::size_t kAtOnce = 256;  // 64 KB
  std::vector<RelativePose> some;
  for (std::size_t first = 0; first < edges.size(); first += some.size()) {
    some.resize(std::min(kAtOnce, edges.size() - first));
    edges.Read(first, some);
    std::ranges::for_each(some, use);
  }
}

Status MemoryEdgeStore::Add(const RelativePose& edge) {
  edges_.push_back(edge);
  return Ok();
}

void MemoryEdgeStore::Read(std::size_t first, std::span<RelativePose> edges) const {
  DEEPSLAM_CHECK(first + edges.size() <= edges_.size(), "edges that are there");
  std::ranges::copy(std::span(edges_).subspan(first, edges.size()), edges.begin());
}

}  // namespace deepslam
