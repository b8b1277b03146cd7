#include "deepslam/detect/new_surface.h"

#include <algorithm>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deepslam::detect {
namespace {

using testing::Each;
using testing::IsEmpty;

const PinholeCamera kCamera{320, 240, 260, 260, 159.5, 119.5};

// A wall, seen square on from this distance.
std::vector<SeenCell> CellsOfWall(double distance_m, const Pose3& world_from_camera) {
  const DepthImage depth_m(kCamera.width, kCamera.height, static_cast<float>(distance_m));
  return SeenCells(depth_m, kCamera, world_from_camera);
}

Pose3 At(double x_m, double z_m = 0) {
  Pose3 pose;
  pose.translation_m = {x_m, 0.05, z_m};
  return pose;
}

std::vector<bool> ShowNew(const std::vector<std::vector<SeenCell>>& frames) {
  return ShowNewSurface(frames);
}

TEST(SeenCells, AreAscendingEachOnceAndNoneWithoutDepth) {
  const std::vector<SeenCell> cells = CellsOfWall(1.5, At(0));
  EXPECT_TRUE(std::ranges::is_sorted(cells));
  EXPECT_EQ(std::ranges::adjacent_find(cells), cells.end());
  // 1.85 x 1.38 m of wall in squares of 0.2 m, some of them in two where directions change.
  EXPECT_GT(cells.size(), 60);
  EXPECT_LT(cells.size(), 160);
  EXPECT_THAT(CellsOfWall(0, At(0)), IsEmpty());
  EXPECT_THAT(CellsOfWall(7, At(0)), IsEmpty());  // too far for a thing
  EXPECT_THAT(SeenCells({}, kCamera, At(0)), IsEmpty());
}

TEST(ShowNewSurface, ACameraThatStandsStillShowsNothingNewAfterAFewFrames) {
  const std::vector<bool> shows = ShowNew(std::vector(20, CellsOfWall(1.5, At(0))));
  EXPECT_TRUE(shows.front());
  EXPECT_GE(std::ranges::count(shows, true), 2);
  EXPECT_LE(std::ranges::count(shows, true), 5);
  EXPECT_FALSE(shows.back());
}

TEST(ShowNewSurface, ACameraThatGoesOnShowsSomethingNew) {
  std::vector<std::vector<SeenCell>> frames;
  for (int k = 0; k < 12; ++k) frames.push_back(CellsOfWall(1.5, At(1.0 * k)));
  EXPECT_THAT(ShowNew(frames), Each(true));
}

TEST(ShowNewSurface, ASlowCameraShowsItOnlyEverySoOften) {
  std::vector<std::vector<SeenCell>> frames;
  for (int k = 0; k < 100; ++k) frames.push_back(CellsOfWall(1.5, At(0.02 * k)));
  const auto num_new = std::ranges::count(ShowNew(frames), true);
  EXPECT_GT(num_new, 5);
  EXPECT_LT(num_new, 50);
}

TEST(ShowNewSurface, WhatComesNearIsNew) {
  std::vector<std::vector<SeenCell>> frames(10, CellsOfWall(3.2, At(0)));
  frames.push_back(CellsOfWall(1.2, At(0, 2.0)));
  EXPECT_FALSE(ShowNew(frames)[9]);
  EXPECT_TRUE(ShowNew(frames)[10]);
}

TEST(ShowNewSurface, AndSoIsTheOtherSide) {
  std::vector<std::vector<SeenCell>> frames(10, CellsOfWall(1.5, At(0)));
  Pose3 from_behind = At(0, 3.0);
  from_behind.rotation = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY());
  frames.push_back(CellsOfWall(1.5, from_behind));
  EXPECT_FALSE(ShowNew(frames)[9]);
  EXPECT_TRUE(ShowNew(frames)[10]);
}

TEST(ShowNewSurface, FramesWithoutDepthCountAsNew) {
  EXPECT_THAT(ShowNew(std::vector<std::vector<SeenCell>>(9)), Each(true));
  EXPECT_THAT(ShowNew({}), IsEmpty());
}

}  // namespace
}  // namespace deepslam::detect
