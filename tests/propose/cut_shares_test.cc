#include "deepslam/propose/cut_shares.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace deepslam::propose {
namespace {

constexpr SolidCut kCut = {.threshold = 0.4, .kept_of_expected = 0.5};

std::vector<float> Nothing() { return std::vector<float>(VoxelGrid().occupied.size(), 0.01F); }

// A seat that is sure.
std::vector<float> Seat() {
  std::vector<float> shares = Nothing();
  for (int i = 10; i < 50; ++i) {
    for (int j = 10; j < 50; ++j) {
      for (int k = 30; k < 34; ++k) shares[VoxelGrid::Index(i, j, k)] = 0.9F;
    }
  }
  return shares;
}

int InLayer(const VoxelGrid& grid, int k) {
  int count = 0;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) count += grid.At(i, j, k) ? 1 : 0;
  }
  return count;
}

TEST(CutSharesTest, ALegWhosePlaceIsUnsureStaysWhereItIsLikeliest) {
  std::vector<float> shares = Seat();
  // Somewhere in 6 x 6 voxels stand 2 x 2 of a leg; rather in the middle.
  for (int i = 10; i < 16; ++i) {
    for (int j = 10; j < 16; ++j) {
      const bool is_middle = i >= 12 && i < 14 && j >= 12 && j < 14;
      for (int k = 0; k < 30; ++k) shares[VoxelGrid::Index(i, j, k)] = is_middle ? 0.3F : 0.1F;
    }
  }
  const VoxelGrid solid = CutShares(shares, kCut);
  for (int k = 0; k < 30; ++k) {
    EXPECT_TRUE(solid.At(12, 13, k)) << k;
    EXPECT_LE(InLayer(solid, k), 22) << "half of what is expected, in all of the layer";
    EXPECT_GE(InLayer(solid, k), 4);
  }
  EXPECT_EQ(InLayer(solid, 32), 1600);
}

TEST(CutSharesTest, WithoutExpectationTheThresholdAloneCuts) {
  std::vector<float> shares = Seat();
  for (int k = 0; k < 30; ++k) shares[VoxelGrid::Index(12, 12, k)] = 0.39F;
  EXPECT_TRUE(CutShares(shares, {.threshold = 0.4, .kept_of_expected = 1}).At(12, 12, 5));
  EXPECT_EQ(CutShares(shares, {.threshold = 0.4, .kept_of_expected = 0}),
            CutShares(Seat(), {.threshold = 0.4, .kept_of_expected = 0}));
}

TEST(CutSharesTest, WhatIsNowhereLikelyStaysEmpty) {
  const VoxelGrid solid = CutShares(Seat(), kCut);
  EXPECT_EQ(std::count(solid.occupied.begin(), solid.occupied.end(), std::uint8_t{1}), 4 * 1600);
  EXPECT_EQ(CutShares(Nothing(), kCut), VoxelGrid());
}

TEST(CutSharesTest, OfEquallyLikelyVoxelsNoneIsPicked) {
  const std::vector<float> even(VoxelGrid().occupied.size(), 0.1F);
  EXPECT_EQ(CutShares(even, kCut), VoxelGrid());
}

TEST(CutSharesTest, SureLayersAreCutAtTheThreshold) {
  std::vector<float> shares = Seat();
  for (int k = 30; k < 34; ++k) shares[VoxelGrid::Index(52, 30, k)] = 0.3F;
  EXPECT_FALSE(CutShares(shares, kCut).At(52, 30, 31));
}

TEST(CutSharesTest, DropsSmallComponentsAndKeepsWhatLiesAVoxelApart) {
  std::vector<float> shares = Seat();
  for (int i = 20; i < 40; ++i) {
    for (int j = 20; j < 40; ++j) shares[VoxelGrid::Index(i, j, 35)] = 0.9F;
  }
  shares[VoxelGrid::Index(20, 20, 60)] = 0.9F;
  const VoxelGrid solid = CutShares(shares, kCut);
  EXPECT_EQ(InLayer(solid, 35), 400);
  EXPECT_EQ(InLayer(solid, 60), 0);
}

}  // namespace
}  // namespace deepslam::propose
