#include "deepslam/refine/mirrored.h"

#include <cstddef>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace deepslam::refine {
namespace {

constexpr std::size_t kViews = 6;
constexpr int kX = 0;
constexpr int kY = 1;

// Posts in free air, of a model in [10, 50)^3.
class MirroredTest : public testing::Test {
 protected:
  MirroredTest() : votes_(VoxelGrid().occupied.size()) {}

  // In low <= index < high.
  void Say(const Eigen::Array3i& low, const Eigen::Array3i& high, const Votes& votes) {
    for (int i = low.x(); i < high.x(); ++i) {
      for (int j = low.y(); j < high.y(); ++j) {
        for (int k = low.z(); k < high.z(); ++k) votes_[VoxelGrid::Index(i, j, k)] = votes;
      }
    }
  }
  // A post of 4 x 4 voxels from layer 10 up to `top`, with free air round it.
  void SayPost(int y, int top) {
    Say({18, y - 2, 10}, {26, y + 6, 50}, {.free = 4});
    Say({20, y, 10}, {24, y + 4, top}, {.object = 4});
  }

  [[nodiscard]] std::optional<MirrorPlane> Find(int axis) const {
    return FindMirrorPlane(votes_, kViews, model_, axis);
  }
  [[nodiscard]] const Votes& At(const std::vector<Votes>& votes, int i, int j, int k) const {
    return votes[VoxelGrid::Index(i, j, k)];
  }

  VoxelBox model_ = {{10, 10, 10}, {49, 49, 49}};  // middle: sum 59
  std::vector<Votes> votes_;
};

TEST_F(MirroredTest, ThePlaneLiesBetweenWhatIsAlike) {
  SayPost(15, 40);
  SayPost(42, 40);  // voxels 42 .. 45 opposite 15 .. 18: sum 60
  const std::optional<MirrorPlane> plane = Find(kY);
  ASSERT_TRUE(plane);
  EXPECT_EQ(plane->axis, kY);
  EXPECT_EQ(plane->sum, 60);
}

TEST_F(MirroredTest, NoPlaneWhereTheOtherSideIsFree) {
  SayPost(15, 40);
  SayPost(42, 20);
  EXPECT_FALSE(Find(kY)) << "one post is three times as high";
}

TEST_F(MirroredTest, NoPlaneWhereTheOtherSideWasNotSeen) {
  SayPost(15, 40);
  EXPECT_FALSE(Find(kY));
  EXPECT_FALSE(Find(kX)) << "the posts stand on one side of the middle";
}

TEST_F(MirroredTest, NoPlaneFarFromTheModelsMiddle) {
  SayPost(15, 40);
  SayPost(22, 40);  // sum 40
  EXPECT_FALSE(Find(kY));
}

TEST_F(MirroredTest, OfTwoPlanesThatAreAlikeTheNearer) {
  Say({10, 10, 30}, {50, 50, 31}, {.object = 4});  // a board that ends nowhere
  const std::optional<MirrorPlane> plane = Find(kY);
  ASSERT_TRUE(plane);
  EXPECT_EQ(plane->sum, 59);
}

TEST_F(MirroredTest, WhatNobodySawIsLikeTheOtherSide) {
  SayPost(15, 40);
  Say({20, 15, 20}, {24, 19, 22}, {.free = 1, .object = 1});  // tells nothing
  Say({20, 15, 25}, {24, 19, 27}, {.free = 3});               // does tell
  SayPost(42, 40);
  Say({18, 13, 30}, {26, 21, 50}, {});  // hidden
  const std::vector<Votes> mirrored = WithMirrored({kY, 60}, votes_, kViews);
  EXPECT_TRUE(At(mirrored, 21, 16, 35).IsMeasured(kViews)) << "as the other post";
  EXPECT_TRUE(At(mirrored, 21, 16, 45).IsFree()) << "above it";
  EXPECT_TRUE(At(mirrored, 21, 16, 21).IsMeasured(kViews));
  EXPECT_TRUE(At(mirrored, 21, 16, 26).IsFree()) << "seen, and not like the other";
  EXPECT_FALSE(At(mirrored, 21, 30, 35).IsFree()) << "nobody saw either";
  EXPECT_FALSE(At(mirrored, 21, 30, 35).HasSurface(kViews));
}

TEST_F(MirroredTest, OneOfSeveralViewsIsNotSure) {
  Say({20, 42, 10}, {24, 46, 20}, {.object = 1});
  Say({20, 42, 20}, {24, 46, 30}, {.free = 1});
  const std::vector<Votes> mirrored = WithMirrored({kY, 60}, votes_, kViews);
  EXPECT_FALSE(At(mirrored, 21, 16, 15).HasSurface(1));
  EXPECT_FALSE(At(mirrored, 21, 16, 25).IsFree());
  EXPECT_TRUE(At(WithMirrored({kY, 60}, votes_, 1), 21, 16, 25).IsFree()) << "the only one is";
}

TEST_F(MirroredTest, OppositesOutsideTheGridSayNothing) {
  Say({0, 0, 0}, {64, 4, 64}, {.object = 4});
  const std::vector<Votes> mirrored = WithMirrored({kY, 40}, votes_, kViews);
  EXPECT_TRUE(At(mirrored, 5, 39, 5).HasSurface(kViews));
  EXPECT_FALSE(At(mirrored, 5, 60, 5).HasSurface(kViews));
}

class InWholeRunsTest : public MirroredTest {
 protected:
  // Of the leg [20, 24) x [15, 19) x [10, 40) that nobody saw.
  [[nodiscard]] bool IsFreed(int k, const std::vector<Votes>& mirrored) const {
    VoxelGrid leg;
    for (int n = 10; n < 40; ++n) {
      for (int i = 20; i < 24; ++i) {
        for (int j = 15; j < 19; ++j) leg.occupied[VoxelGrid::Index(i, j, n)] = 1;
      }
    }
    return At(InWholeRuns(leg, votes_, mirrored, kViews), 22, 17, k).IsFree();
  }
  // The leg's opposite is free from layer `low` up.
  [[nodiscard]] std::vector<Votes> FreeFrom(int low) {
    Say({20, 42, low}, {24, 46, 50}, {.free = 4});
    return WithMirrored({kY, 60}, votes_, kViews);
  }
};

TEST_F(InWholeRunsTest, ALegGoesAsAWhole) {
  const std::vector<Votes> mirrored = FreeFrom(20);
  ASSERT_FALSE(At(mirrored, 22, 17, 12).IsFree()) << "nobody saw either";
  for (const int k : {10, 12, 25, 39}) EXPECT_TRUE(IsFreed(k, mirrored)) << k;
}

TEST_F(InWholeRunsTest, OrStaysAsAWhole) {
  const std::vector<Votes> mirrored = FreeFrom(30);
  ASSERT_TRUE(At(mirrored, 22, 17, 35).IsFree());
  for (const int k : {10, 12, 35, 39}) EXPECT_FALSE(IsFreed(k, mirrored)) << k;
}

TEST_F(InWholeRunsTest, WhatWasMeasuredOnEitherSideStays) {
  Say({20, 42, 20}, {24, 46, 50}, {.free = 4});
  Say({20, 42, 32}, {24, 46, 34}, {.object = 4});
  Say({20, 15, 36}, {24, 19, 37}, {.object = 4});
  const std::vector<Votes> mirrored = WithMirrored({kY, 60}, votes_, kViews);
  EXPECT_TRUE(IsFreed(31, mirrored));
  EXPECT_FALSE(IsFreed(33, mirrored));
  EXPECT_FALSE(IsFreed(36, mirrored));
  EXPECT_TRUE(IsFreed(38, mirrored)) << "a run of its own";
}

TEST_F(InWholeRunsTest, WhatWasSeenToBeFreeIs) {
  Say({20, 15, 10}, {24, 19, 40}, {.free = 4});
  EXPECT_TRUE(IsFreed(12, votes_));
}

}  // namespace
}  // namespace deepslam::refine
