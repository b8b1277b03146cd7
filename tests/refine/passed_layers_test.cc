#include "deepslam/refine/passed_layers.h"

#include <vector>

#include <gtest/gtest.h>

namespace deepslam::refine {
namespace {

constexpr std::size_t kViews = 12;
constexpr Votes kPassed = {.free = 8};
constexpr Votes kSurface = {.object = 8};
constexpr Votes kHidden = {};

// A model's board, of the voxels [10, 50) x [10, 40) x [30, 36), whose layers are said to be
// something from a side inwards.
class WithoutPassedLayersTest : public testing::Test {
 protected:
  WithoutPassedLayersTest() : votes_(model_.occupied.size(), kHidden) {
    for (int i = 10; i < 50; ++i) {
      for (int j = 10; j < 40; ++j) {
        for (int k = 30; k < 36; ++k) model_.occupied[VoxelGrid::Index(i, j, k)] = 1;
      }
    }
    Say({9, 9, 0}, {51, 41, 64}, kPassed);
    Say({10, 10, 30}, {50, 40, 36}, kHidden);
    Say({10, 10, 35}, {50, 40, 36}, kSurface);  // of the board
  }

  // In low <= index < high.
  void Say(const Eigen::Array3i& low, const Eigen::Array3i& high, const Votes& votes) {
    for (int i = low.x(); i < high.x(); ++i) {
      for (int j = low.y(); j < high.y(); ++j) {
        for (int k = low.z(); k < high.z(); ++k) votes_[VoxelGrid::Index(i, j, k)] = votes;
      }
    }
  }
  // The outermost two voxels of layers [low, high).
  void SayRim(int low, int high, const Votes& votes) {
    Say({10, 10, low}, {12, 40, high}, votes);
    Say({48, 10, low}, {50, 40, high}, votes);
    Say({10, 10, low}, {50, 12, high}, votes);
    Say({10, 38, low}, {50, 40, high}, votes);
  }

  [[nodiscard]] VoxelGrid Thinner() const { return WithoutPassedLayers(model_, votes_, kViews); }
  // Of the board, far from its rim.
  static bool Has(const VoxelGrid& grid, int k) { return grid.At(30, 25, k); }

  VoxelGrid model_;
  std::vector<Votes> votes_;
};

TEST_F(WithoutPassedLayersTest, WhatRaysPassedAllRoundBelowTheSurfaceIsNotThere) {
  SayRim(33, 35, kSurface);
  SayRim(30, 33, kPassed);
  const VoxelGrid thinner = Thinner();
  for (int k = 30; k < 33; ++k) EXPECT_FALSE(Has(thinner, k)) << "layer " << k;
  for (int k = 33; k < 36; ++k) EXPECT_TRUE(Has(thinner, k)) << "layer " << k;
}

TEST_F(WithoutPassedLayersTest, WhatHasSidesStays) {
  SayRim(30, 35, kSurface);
  EXPECT_EQ(Thinner(), model_);
}

TEST_F(WithoutPassedLayersTest, WhatIsSeenFromOneSideIsScoredByIt) {
  SayRim(33, 35, kSurface);
  Say({10, 10, 30}, {12, 40, 33}, kPassed);
  const VoxelGrid thinner = Thinner();
  EXPECT_FALSE(Has(thinner, 31));
  EXPECT_TRUE(Has(thinner, 34));
}

TEST_F(WithoutPassedLayersTest, AGapInTheRimTellsNothingOfTheRest) {
  SayRim(30, 35, kSurface);
  Say({20, 10, 30}, {30, 12, 33}, kPassed);
  EXPECT_TRUE(Has(Thinner(), 31)) << "more of the edge is surface";
  SayRim(30, 35, kHidden);
  Say({20, 10, 30}, {24, 12, 33}, kPassed);
  EXPECT_TRUE(Has(Thinner(), 31)) << "of most of the edge nobody knows";
}

TEST_F(WithoutPassedLayersTest, RaysThatPassBesideTellNothing) {
  Say({10, 10, 35}, {50, 40, 36}, kHidden);
  EXPECT_EQ(Thinner(), model_) << "no surface was seen above them";
}

TEST_F(WithoutPassedLayersTest, AnEdgeThatMostLookPastIsNoSide) {
  SayRim(33, 35, kSurface);
  SayRim(30, 33, kPassed);
  Say({12, 12, 30}, {13, 38, 33}, {.free = 1, .object = 3});
  Say({47, 12, 30}, {48, 38, 33}, {.free = 1, .object = 3});
  Say({12, 12, 30}, {48, 13, 33}, {.free = 1, .object = 3});
  Say({12, 37, 30}, {48, 38, 33}, {.free = 1, .object = 3});
  EXPECT_FALSE(Has(Thinner(), 31)) << "eight rays went past what three have measured";
  Say({12, 12, 30}, {13, 38, 33}, kSurface);
  Say({47, 12, 30}, {48, 38, 33}, kSurface);
  Say({12, 12, 30}, {48, 13, 33}, kSurface);
  Say({12, 37, 30}, {48, 38, 33}, kSurface);
  EXPECT_TRUE(Has(Thinner(), 31)) << "and eight measured it";
}

TEST_F(WithoutPassedLayersTest, LegsThatSegmentationMissedStay) {
  SayRim(33, 35, kSurface);
  Say({10, 10, 30}, {50, 40, 33}, kPassed);
  Say({20, 20, 30}, {23, 23, 33}, {.free = 1, .other = 5});
  Say({40, 20, 30}, {43, 23, 33}, {.free = 1, .object = 5});
  const VoxelGrid thinner = Thinner();
  EXPECT_TRUE(thinner.At(21, 21, 31));
  EXPECT_TRUE(thinner.At(41, 21, 31));
}

TEST_F(WithoutPassedLayersTest, ALegStaysWhereFewRaysPassedIt) {
  for (int i = 20; i < 24; ++i) {
    for (int j = 20; j < 24; ++j) {
      for (int k = 5; k < 30; ++k) model_.occupied[VoxelGrid::Index(i, j, k)] = 1;
    }
  }
  SayRim(33, 35, kSurface);
  Say({10, 10, 5}, {50, 40, 33}, kHidden);
  SayRim(30, 33, kPassed);
  Say({20, 24, 15}, {24, 25, 30}, kPassed);
  EXPECT_TRUE(Thinner().At(21, 21, 20)) << "on one side of four";
  EXPECT_FALSE(Has(Thinner(), 31)) << "the top above it is as thin as before";
  Say({24, 19, 15}, {25, 25, 30}, kPassed);
  Say({20, 19, 15}, {24, 20, 30}, kPassed);
  EXPECT_FALSE(Thinner().At(21, 21, 20)) << "on three";
}

TEST_F(WithoutPassedLayersTest, NothingIsKnownWithoutViews) {
  votes_.assign(votes_.size(), kHidden);
  EXPECT_EQ(WithoutPassedLayers(model_, votes_, 0), model_);
}

}  // namespace
}  // namespace deepslam::refine
