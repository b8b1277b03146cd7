#include "deepslam/stages/disk_edge_store.h"

#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/scene/measured_parts.h"
#include "stages/edge_samples.h"
#include "support/temp_dir.h"

namespace deepslam::stages {
namespace {

using testing_support::SampleEdges;
using testing_support::StoreOf;
using testing_support::TempDir;

void ExpectEqual(const RelativePose& a, const RelativePose& b) {
  EXPECT_EQ(a.i, b.i);
  EXPECT_EQ(a.j, b.j);
  EXPECT_EQ(a.i_from_j, b.i_from_j);
  EXPECT_EQ(a.information, b.information);
  EXPECT_EQ(a.composed, b.composed);
}

class DiskStoreOfSoManyEdges : public ::testing::TestWithParam<int> {};

// Whether all are on their way to the file, some, or none.
TEST_P(DiskStoreOfSoManyEdges, GivesThemBackToTheLastBit) {
  const TempDir dir;
  const std::vector<RelativePose> edges = SampleEdges(GetParam());
  const auto store = StoreOf(edges, dir.path());
  ASSERT_EQ(store->size(), edges.size());
  std::size_t n = 0;
  ForEach(*store, [&](const RelativePose& edge) { ExpectEqual(edge, edges[n++]); });
  EXPECT_EQ(n, edges.size());
  for (std::size_t first = 0; first < edges.size(); first += 77) {
    std::vector<RelativePose> some(std::min<std::size_t>(50, edges.size() - first));
    store->Read(first, some);
    for (std::size_t k = 0; k < some.size(); ++k) ExpectEqual(some[k], edges[first + k]);
  }
}

INSTANTIATE_TEST_SUITE_P(Edges,
                         DiskStoreOfSoManyEdges,
                         ::testing::Values(0, 1, 255, 256, 257, 1000));

TEST(DiskEdgeStore, ComeBehindThoseThatAreHeld) {
  const TempDir dir;
  const std::vector<RelativePose> edges = SampleEdges(700);
  Odometry whole;
  whole.edges = edges;
  Odometry out_of_core;
  out_of_core.edges.assign(edges.begin(), edges.begin() + 100);
  out_of_core.more_edges = StoreOf({edges.begin() + 100, edges.end()}, dir.path());
  EXPECT_EQ(out_of_core.num_edges(), edges.size());
  std::size_t n = 0;
  out_of_core.ForEachEdge([&](const RelativePose& edge) { ExpectEqual(edge, edges[n++]); });
  EXPECT_EQ(n, edges.size());
  const std::vector<KeyframeJoin> joins = JoinsOf(out_of_core);
  const std::vector<KeyframeJoin> expected = JoinsOf(whole);
  ASSERT_EQ(joins.size(), expected.size());
  for (std::size_t k = 0; k < joins.size(); ++k) {
    EXPECT_EQ(joins[k].i, expected[k].i);
    EXPECT_EQ(joins[k].j, expected[k].j);
    EXPECT_EQ(joins[k].composed, expected[k].composed);
  }
}

// As a disk that fails would have it.
TEST(DiskEdgeStore, WhatTheMachineDoesNotGiveJoinsNothing) {
  const TempDir dir;
  const auto file = std::make_shared<storage::ScratchFile>(dir.path());
  const auto other = std::make_shared<storage::ScratchFile>(dir.path());
  DiskEdgeStore store(file);
  ASSERT_TRUE(AddAll(SampleEdges(256), store).ok());
  RelativePose edge;
  DiskEdgeStore broken(other);
  ASSERT_TRUE(AddAll(SampleEdges(256), broken).ok());
  const std::vector<std::byte> none(file->num_bytes());
  store.Read(0, {&edge, 1});
  EXPECT_TRUE(edge.i.valid() && edge.j.valid());
  ASSERT_TRUE(other->Append(none).ok());  // zeros where a second block should be
  ASSERT_TRUE(AddAll(SampleEdges(256), broken).ok());
  broken.Read(256, {&edge, 1});
  EXPECT_FALSE(edge.i.valid());
  EXPECT_FALSE(edge.j.valid());
}

}  // namespace
}  // namespace deepslam::stages
