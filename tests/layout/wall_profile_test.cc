#include "deepslam/layout/wall_profile.h"

#include <vector>

#include <gtest/gtest.h>

#include "layout/box_rooms.h"

namespace deepslam::layout {
namespace {

// The north wall of a room, y = 1.5, with a window in it, and a counter before its right half.
CoarseSurface Surface() {
  std::vector<Cuboid> world;
  AddWall({true, 1.5, -2.2, 2.2, 0.2, {{-1.0, 0.0, 0.9, 1.9}}}, world);
  AddBox({0.5, 0.9, 0}, {2, 1.5, 0.9}, world);
  std::vector<Pose3> poses;
  for (const double x : {-0.8, 0.0, 0.8}) {
    for (const double z : {0.5, 1.5, 2.4})
      poses.push_back(testing_support::LookAt({x, -1.2, 1.5}, {x, 1.5, z}));
  }
  return SurfaceOf(world, poses);
}

WallLine FacingSouth(double at_m) {
  WallLine line;
  line.normal = {0, -1};
  line.offset_m = -at_m;
  return line;
}

constexpr ProfileReach kReach{-3, 3, -0.1, 2.6};

int CellAt(const WallProfile& profile, double position_m, double height_m) {
  return profile.at(profile.SlotOf(position_m),
                    static_cast<int>((height_m - profile.bottom_m) / kCell_m));
}

// With the free side to the left, the line runs towards -x: positions are -x.
TEST(WallProfile, TellsWallFromWindowFromHidden) {
  const WallProfile profile = ProfileOf(Surface(), FacingSouth(1.5), kReach, ProfileOptions());
  ASSERT_NEAR(FacingSouth(1.5).along().x(), -1, 1e-12);
  EXPECT_NE(CellAt(profile, 1.5, 1.5) & kSolid, 0);             // wall
  EXPECT_EQ(CellAt(profile, 0.5, 1.4) & kSolid, 0);             // window
  EXPECT_NE(CellAt(profile, 0.5, 1.4) & kBlind, 0);             // nothing is behind it
  EXPECT_EQ(CellAt(profile, -1.2, 0.4) & (kSolid | kOpen), 0);  // behind the counter
  EXPECT_NE(CellAt(profile, -1.2, 1.4) & kSolid, 0);            // above it
  EXPECT_EQ(profile.WallShare(-1.8, 1.8), 1);                   // sill and lintel are wall too
}

TEST(WallProfile, TheFrontOfACounterIsNoWall) {
  const WallProfile profile = ProfileOf(Surface(), FacingSouth(0.9), kReach, ProfileOptions());
  EXPECT_NE(CellAt(profile, -1.2, 0.5) & kSolid, 0);
  EXPECT_NE(CellAt(profile, -1.2, 1.3) & kOpen, 0);
  EXPECT_EQ(profile.WallShare(-2, 2), 0);
  EXPECT_TRUE(profile.WallRuns().empty());
}

// A wardrobe nearly as high as anybody looked: a strip of two cells shows over it.
TEST(WallProfile, TheFrontOfAWardrobeIsNoWallWhereverOneLooksOverIt) {
  std::vector<Cuboid> world;
  AddWall({true, 1.5, -2.2, 2.2, 0.2, {}}, world);
  AddBox({0.2, 0.9, 0}, {1.6, 1.5, 1.9}, world);
  std::vector<Pose3> poses;
  for (const double x : {-0.8, 0.0, 0.8, 1.2})
    poses.push_back(testing_support::LookAt({x, -1.2, 1.5}, {x, 1.5, 1.0}));
  const CoarseSurface surface = SurfaceOf(world, poses);
  const WallProfile front = ProfileOf(surface, FacingSouth(0.9), kReach, ProfileOptions());
  ASSERT_NE(CellAt(front, -0.9, 1.5) & kSolid, 0);
  int num_over = 0;
  for (int row = 0; row < front.num_rows; ++row)
    num_over += (front.at(front.SlotOf(-0.9), row) & kOpen) != 0 && front.HeightOf(row) > 1.9;
  ASSERT_GT(num_over, 0);
  ASSERT_LT(num_over * kCell_m, ProfileOptions().max_open_above_m) << "one slot does not tell";
  EXPECT_EQ(front.WallShare(-1.6, -0.2), 0);
  const WallProfile wall = ProfileOf(surface, FacingSouth(1.5), kReach, ProfileOptions());
  EXPECT_EQ(wall.WallShare(0.2, 1.2), 1);
}

TEST(WallProfile, OutsideItsReachThereIsNothing) {
  const WallProfile profile = ProfileOf(Surface(), FacingSouth(1.5), kReach, ProfileOptions());
  EXPECT_EQ(profile.WallShare(10, 12), 0);
  EXPECT_EQ(profile.WallShare(-12, -10), 0);
}

}  // namespace
}  // namespace deepslam::layout
