#include "deepslam/scene/edge_store.h"

#include <vector>

#include <gtest/gtest.h>

namespace deepslam {
namespace {

std::vector<RelativePose> Edges(int count) {
  std::vector<RelativePose> edges;
  for (int k = 0; k < count; ++k)
    edges.push_back({FrameIdx{k}, FrameIdx{k + 1}, Pose3{}, Matrix6d::Identity(), k % 2 == 0});
  return edges;
}

TEST(MemoryEdgeStore, GivesBackWhatWasAddedInItsOrder) {
  MemoryEdgeStore store;
  ASSERT_TRUE(AddAll(Edges(7), store).ok());
  ASSERT_EQ(store.size(), 7u);
  std::vector<RelativePose> some(3);
  store.Read(2, some);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(some[static_cast<std::size_t>(k)].i, FrameIdx{k + 2});
    EXPECT_EQ(some[static_cast<std::size_t>(k)].composed, k % 2 == 0);
  }
  store.Read(7, {});  // nothing behind the last one is nothing
}

TEST(MemoryEdgeStoreDeathTest, HasNoEdgesThatWereNotAdded) {
  MemoryEdgeStore store;
  ASSERT_TRUE(AddAll(Edges(2), store).ok());
  std::vector<RelativePose> three(3);
  EXPECT_DEATH(store.Read(0, three), "edges that are there");
}

class FullAfter final : public EdgeStore {
 public:
  explicit FullAfter(std::size_t most) : most_(most) {}
  [[nodiscard]] Status Add(const RelativePose&) override {
    if (num_edges_ == most_) return Failed("no space left");
    ++num_edges_;
    return Ok();
  }
  [[nodiscard]] std::size_t size() const override { return num_edges_; }
  void Read(std::size_t, std::span<RelativePose>) const override {}

 private:
  std::size_t most_;
  std::size_t num_edges_ = 0;
};

TEST(AddAll, EndsWithTheFirstError) {
  FullAfter store(3);
  const Status status = AddAll(Edges(5), store);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, "no space left");
  EXPECT_EQ(store.size(), 3u);
}

}  // namespace
}  // namespace deepslam
