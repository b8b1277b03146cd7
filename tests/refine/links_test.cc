#include "deepslam/refine/links.h"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/shape/small_components.h"

namespace deepslam::refine {
namespace {

constexpr std::uint8_t kBlocked = 0;

// Solid where low <= index < high along each axis.
void AddBox(const Eigen::Array3i& low, const Eigen::Array3i& high, VoxelGrid& grid) {
  for (int i = low.x(); i < high.x(); ++i) {
    for (int j = low.y(); j < high.y(); ++j) {
      for (int k = low.z(); k < high.z(); ++k) grid.occupied[VoxelGrid::Index(i, j, k)] = 1;
    }
  }
}

// A top on two legs of 3 x 3 voxels.
VoxelGrid Table() {
  VoxelGrid grid;
  AddBox({10, 10, 40}, {50, 30, 43}, grid);
  AddBox({10, 10, 5}, {13, 13, 40}, grid);
  AddBox({47, 27, 5}, {50, 30, 40}, grid);
  return grid;
}

// The table without what lies from layer `low` to before layer `high`.
VoxelGrid Severed(int low, int high) {
  VoxelGrid grid = Table();
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = low; k < high; ++k) grid.occupied[VoxelGrid::Index(i, j, k)] = 0;
    }
  }
  return grid;
}

std::vector<std::uint8_t> Costs(std::uint8_t where_model, std::uint8_t elsewhere) {
  const VoxelGrid model = Table();
  std::vector<std::uint8_t> costs(model.occupied.size(), elsewhere);
  for (std::size_t n = 0; n < costs.size(); ++n) {
    if (model.occupied[n] != 0) costs[n] = where_model;
  }
  return costs;
}

TEST(WithLinks, LegsThatWereCutOffHangOnTheTopAgainAsTheModelHasThem) {
  const VoxelGrid severed = Severed(30, 40);
  ASSERT_EQ(shape::PartsOf(severed, 1).size(), 3U);
  const VoxelGrid table = Table();
  const VoxelGrid linked = WithLinks(severed, table, Costs(1, kBlocked), 20);
  EXPECT_EQ(shape::PartsOf(linked, 1).size(), 1U);
  for (std::size_t n = 0; n < linked.occupied.size(); ++n) {
    ASSERT_LE(linked.occupied[n], table.occupied[n]) << "links stay in the model";
    ASSERT_GE(linked.occupied[n], severed.occupied[n]) << "nothing is taken away";
  }
}

TEST(WithLinks, NothingGoesWhereRaysWent) {
  const VoxelGrid severed = Severed(30, 40);
  EXPECT_EQ(WithLinks(severed, Table(), Costs(kBlocked, kBlocked), 100), severed);
}

TEST(WithLinks, LinksAreNoLongerThanTheyMayBe) {
  const VoxelGrid severed = Severed(30, 40);  // ten voxels, and the step into the other part
  EXPECT_EQ(WithLinks(severed, Table(), Costs(1, kBlocked), 10), severed);
  EXPECT_EQ(WithLinks(severed, Table(), Costs(2, kBlocked), 20), severed);
  EXPECT_EQ(shape::PartsOf(WithLinks(severed, Table(), Costs(2, kBlocked), 21), 1).size(), 1U);
}

TEST(WithLinks, GoThroughTheModelWhereThatCostsLess) {
  const VoxelGrid table = Table();
  const VoxelGrid linked = WithLinks(Severed(30, 40), table, Costs(1, 2), 40);
  EXPECT_EQ(shape::PartsOf(linked, 1).size(), 1U);
  for (std::size_t n = 0; n < linked.occupied.size(); ++n)
    ASSERT_LE(linked.occupied[n], table.occupied[n]);
}

TEST(WithLinks, PartsMayHangOnOneAnother) {
  // A pile of three: the lowest is too far from the highest, which is the largest.
  VoxelGrid pile;
  AddBox({20, 20, 40}, {40, 40, 60}, pile);
  AddBox({28, 28, 25}, {32, 32, 35}, pile);
  AddBox({28, 28, 10}, {32, 32, 20}, pile);
  const std::vector<std::uint8_t> anywhere(pile.occupied.size(), 1);
  EXPECT_EQ(shape::PartsOf(WithLinks(pile, VoxelGrid(), anywhere, 6), 1).size(), 1U);
  EXPECT_EQ(shape::PartsOf(WithLinks(pile, VoxelGrid(), anywhere, 5), 1).size(), 3U);
}

TEST(WithLinks, WhatHangsTogetherAndNothingStayAsTheyAre) {
  EXPECT_EQ(WithLinks(Table(), Table(), Costs(1, 1), 100), Table());
  EXPECT_EQ(WithLinks(VoxelGrid(), Table(), Costs(1, 1), 100), VoxelGrid());
}

}  // namespace
}  // namespace deepslam::refine
