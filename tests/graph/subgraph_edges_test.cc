#include "deepslam/graph/subgraph_edges.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/disjoint_sets.h"

namespace deepslam::graph {
namespace {

using ::testing::ElementsAre;

GraphModel Keyframes(int num_keyframes) {
  GraphModel model;
  for (int k = 0; k < num_keyframes; ++k) model.keyframes.push_back(FrameIdx{3 * k});
  model.world_from_node.resize(model.keyframes.size());
  return model;
}

void Add(EdgeKind kind, int a, int b, GraphModel& model) {
  model.pose_edges.push_back({kind, a, b, {}, Matrix6d::Identity()});
}

std::set<std::pair<int, int>> Pairs(const GraphModel& model) {
  std::set<std::pair<int, int>> pairs;
  for (const std::size_t k : SubgraphEdges(model))
    pairs.insert({model.pose_edges[k].a, model.pose_edges[k].b});
  return pairs;
}

// A path that goes round again and again, each keyframe registered to many before it and tied to
// two earlier rounds.
GraphModel Rounds(int num_keyframes, int round) {
  GraphModel model = Keyframes(num_keyframes);
  for (int b = 1; b < num_keyframes; ++b) {
    for (int a = std::max(0, b - 12); a < b; ++a) Add(EdgeKind::kOdometry, a, b, model);
    for (int a = b - round; a >= 0; a -= round) Add(EdgeKind::kLoop, a, b, model);
  }
  return model;
}

TEST(SubgraphEdges, JoinEveryKeyframeWithFewEdges) {
  const GraphModel model = Rounds(100, 20);
  const std::vector<std::size_t> subgraph = SubgraphEdges(model);
  EXPECT_TRUE(std::ranges::is_sorted(subgraph));
  EXPECT_EQ(std::ranges::adjacent_find(subgraph), subgraph.end());
  EXPECT_LT(subgraph.size(), model.keyframes.size() + 10);
  DisjointSets joined(model.keyframes.size());
  for (const std::size_t k : subgraph)
    joined.Join(static_cast<std::uint32_t>(model.pose_edges[k].a),
                static_cast<std::uint32_t>(model.pose_edges[k].b));
  for (std::uint32_t k = 0; k < 100; ++k) EXPECT_EQ(joined.LeastOf(k), 0U) << k;
}

TEST(SubgraphEdges, AreThePathAndNowAndThenALoopToTheRoundBefore) {
  constexpr int kRound = 20;
  std::set<std::pair<int, int>> pairs = Pairs(Rounds(90, kRound));
  for (int k = 1; k < 90; ++k) EXPECT_EQ(pairs.erase({k - 1, k}), 1U) << k;
  std::set<int> newer;
  for (const auto& [a, b] : pairs) {
    EXPECT_EQ(b - a, kRound);
    newer.insert(b);
  }
  ASSERT_GE(newer.size(), 4U);
  for (auto next = std::next(newer.begin()); next != newer.end(); ++next)
    EXPECT_GT(*next - *std::prev(next), 10);
}

// Tracking was lost between 2 and 3: what leads over the gap carries, however far it reaches.
TEST(SubgraphEdges, LeadOverABreakByTheShortestWay) {
  GraphModel model = Keyframes(6);
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {3, 4}, {4, 5}})
    Add(EdgeKind::kOdometry, a, b, model);
  Add(EdgeKind::kOdometry, 0, 5, model);
  Add(EdgeKind::kOdometry, 1, 4, model);
  EXPECT_THAT(
      Pairs(model),
      ElementsAre(
          std::pair(0, 1), std::pair(1, 2), std::pair(1, 4), std::pair(3, 4), std::pair(4, 5)));
}

TEST(SubgraphEdges, HoldAllOfAnObject) {
  GraphModel model = Keyframes(3);
  Add(EdgeKind::kObject, 0, 3, model);
  Add(EdgeKind::kObject, 2, 3, model);
  EXPECT_THAT(SubgraphEdges(model), ElementsAre(0, 1));
  EXPECT_TRUE(SubgraphEdges(GraphModel{}).empty());
}

}  // namespace
}  // namespace deepslam::graph
