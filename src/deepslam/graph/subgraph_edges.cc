#include "deepslam/graph/subgraph_edges.h"

#include <algorithm>
#include <cstdlib>
#include <set>

#include "deepslam/core/disjoint_sets.h"

namespace deepslam::graph {
namespace {

constexpr int kLoopSpacing = 10;  // nodes: the factor of closer ones fills and helps no more

// Keyframes between the two.
int Reach(const PoseEdge& edge) { return std::abs(edge.a - edge.b); }

// Edges between keyframes, those that reach least first.
std::vector<std::size_t> ShortestFirst(const GraphModel& model) {
  std::vector<std::size_t> edges;
  for (std::size_t k = 0; k < model.pose_edges.size(); ++k) {
    if (model.pose_edges[k].kind != EdgeKind::kObject) edges.push_back(k);
  }
  std::ranges::stable_sort(edges, {}, [&](std::size_t k) { return Reach(model.pose_edges[k]); });
  return edges;
}

bool IsApart(int newer, const std::set<int>& loops) {
  const auto nearest = loops.lower_bound(newer - kLoopSpacing);
  return nearest == loops.end() || *nearest > newer + kLoopSpacing;
}

}  // namespace

std::vector<std::size_t> SubgraphEdges(const GraphModel& model) {
  std::vector<std::size_t> subgraph;
  DisjointSets joined(model.keyframes.size());
  std::set<int> loops;  // their newer keyframes
  for (const std::size_t k : ShortestFirst(model)) {
    const PoseEdge& edge = model.pose_edges[k];
    const int newer = std::max(edge.a, edge.b);
    const bool joins =
        joined.Join(static_cast<std::uint32_t>(edge.a), static_cast<std::uint32_t>(edge.b));
    const bool ties_rounds = !joins && edge.kind == EdgeKind::kLoop && IsApart(newer, loops);
    if (ties_rounds) loops.insert(newer);
    if (joins || ties_rounds) subgraph.push_back(k);
  }
  for (std::size_t k = 0; k < model.pose_edges.size(); ++k) {
    if (model.pose_edges[k].kind == EdgeKind::kObject) subgraph.push_back(k);
  }
  std::ranges::sort(subgraph);
  return subgraph;
}

}  // namespace deepslam::graph
