#include "deepslam/stages/shelf_of_edges.h"

#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/scene/measured_parts.h"
#include "stages/edge_samples.h"
#include "support/temp_dir.h"

namespace deepslam::stages {
namespace {

using testing_support::SampleEdges;
using testing_support::ShelfOf;
using testing_support::TempDir;

void ExpectEqual(const RelativePose& a, const RelativePose& b) {
  EXPECT_EQ(a.i, b.i);
  EXPECT_EQ(a.j, b.j);
  EXPECT_EQ(a.i_from_j, b.i_from_j);
  EXPECT_EQ(a.information, b.information);
  EXPECT_EQ(a.composed, b.composed);
}

class ShelfOfSoManyEdges : public ::testing::TestWithParam<int> {};

// Whether all are on their way to the file, some, or none.
TEST_P(ShelfOfSoManyEdges, GivesThemBackToTheLastBit) {
  const TempDir dir;
  const std::vector<RelativePose> edges = SampleEdges(GetParam());
  const auto shelf = ShelfOf(edges, dir.path());
  ASSERT_EQ(shelf->size(), edges.size());
  std::size_t n = 0;
  ForEach(*shelf, [&](const RelativePose& edge) { ExpectEqual(edge, edges[n++]); });
  EXPECT_EQ(n, edges.size());
  for (std::size_t first = 0; first < edges.size(); first += 77) {
    std::vector<RelativePose> some(std::min<std::size_t>(50, edges.size() - first));
    shelf->Read(first, some);
    for (std::size_t k = 0; k < some.size(); ++k) ExpectEqual(some[k], edges[first + k]);
  }
}

INSTANTIATE_TEST_SUITE_P(Edges, ShelfOfSoManyEdges, ::testing::Values(0, 1, 255, 256, 257, 1000));

TEST(ShelfOfEdges, ComeBehindThoseThatAreHeld) {
  const TempDir dir;
  const std::vector<RelativePose> edges = SampleEdges(700);
  Odometry whole;
  whole.edges = edges;
  Odometry shelved;
  shelved.edges.assign(edges.begin(), edges.begin() + 100);
  shelved.more_edges = ShelfOf({edges.begin() + 100, edges.end()}, dir.path());
  EXPECT_EQ(shelved.num_edges(), edges.size());
  std::size_t n = 0;
  shelved.ForEachEdge([&](const RelativePose& edge) { ExpectEqual(edge, edges[n++]); });
  EXPECT_EQ(n, edges.size());
  const std::vector<KeyframeJoin> joins = JoinsOf(shelved);
  const std::vector<KeyframeJoin> expected = JoinsOf(whole);
  ASSERT_EQ(joins.size(), expected.size());
  for (std::size_t k = 0; k < joins.size(); ++k) {
    EXPECT_EQ(joins[k].i, expected[k].i);
    EXPECT_EQ(joins[k].j, expected[k].j);
    EXPECT_EQ(joins[k].composed, expected[k].composed);
  }
}

// As a disk that fails would have it.
TEST(ShelfOfEdges, WhatTheMachineDoesNotGiveJoinsNothing) {
  const TempDir dir;
  const auto file = std::make_shared<storage::ScratchFile>(dir.path());
  const auto other = std::make_shared<storage::ScratchFile>(dir.path());
  ShelfOfEdges shelf(file);
  ASSERT_TRUE(shelf.Add(SampleEdges(256)).ok());
  RelativePose edge;
  ShelfOfEdges broken(other);
  ASSERT_TRUE(broken.Add(SampleEdges(256)).ok());
  const std::vector<std::byte> none(file->num_bytes());
  shelf.Read(0, {&edge, 1});
  EXPECT_TRUE(edge.i.valid() && edge.j.valid());
  ASSERT_TRUE(other->Append(none).ok());  // zeros where a second block should be
  ASSERT_TRUE(broken.Add(SampleEdges(256)).ok());
  broken.Read(256, {&edge, 1});
  EXPECT_FALSE(edge.i.valid());
  EXPECT_FALSE(edge.j.valid());
}

}  // namespace
}  // namespace deepslam::stages
