#include "deepslam/layout/furniture_fronts.h"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace deepslam::layout {
namespace {

constexpr double kUsualTop_m = 2.4;

struct Seen {
  double from_m = 0;
  double to_m = 0;
  double top_m = kUsualTop_m;
};

// Adds a line with wall on these runs of it, solid from the ground up.
void Add(const Eigen::Vector2d& normal,
         double offset_m,
         const std::vector<Seen>& runs,
         WallLines& walls) {
  WallLine line;
  line.normal = normal;
  line.offset_m = offset_m;
  WallProfile profile;
  profile.begin_m = -5;
  profile.num_slots = 200;
  profile.num_rows = 52;
  profile.cells.assign(std::size_t{200} * 52, 0);
  profile.offset_m.assign(profile.cells.size(), 0);
  profile.is_wall.assign(200, 0);
  for (const Seen& run : runs) {
    for (int slot = profile.SlotOf(run.from_m + 0.01); profile.PositionOf(slot) < run.to_m;
         ++slot) {
      profile.is_wall[static_cast<std::size_t>(slot)] = 1;
      for (int row = 0; profile.HeightOf(row + 1) < run.top_m + 0.01; ++row)
        profile.cells[static_cast<std::size_t>(slot) * 52 + static_cast<std::size_t>(row)] = kSolid;
    }
  }
  walls.lines.push_back(line);
  walls.profiles.push_back(std::move(profile));
}

// Walls face +y along x, positions are x. A wardrobe of 1.7 m at x = 0 hides its part of the wall.
struct Wardrobe {
  double depth_m = 0.6;
  double top_m = 2.0;
  double length_m = 1.7;
  bool hides = true;
};

WallLines RoomWith(const Wardrobe& wardrobe) {
  WallLines walls;
  const double end_m = wardrobe.length_m;
  if (wardrobe.hides) {
    Add({0, 1}, 0, {{-2, 0}, {end_m, end_m + 1}}, walls);
  } else {
    Add({0, 1}, 0, {{-2, end_m + 1}}, walls);
  }
  Add({0, 1}, wardrobe.depth_m, {{0, end_m, wardrobe.top_m}}, walls);
  Add({-1, 0}, 0, {{0, wardrobe.depth_m, wardrobe.top_m}}, walls);  // its side: positions are y
  return walls;
}

std::size_t NumKept(WallLines walls) {
  DropFurniture(kUsualTop_m, walls);
  EXPECT_EQ(walls.lines.size(), walls.profiles.size());
  return walls.lines.size();
}

TEST(FurnitureFronts, AreNoWalls) {
  WallLines walls = RoomWith({});
  ASSERT_EQ(walls.lines.size(), 3U);
  DropFurniture(kUsualTop_m, walls);
  ASSERT_EQ(walls.lines.size(), 1U) << "front and side";
  EXPECT_EQ(walls.lines[0].offset_m, 0);
  EXPECT_EQ(walls.profiles[0].WallRuns().size(), 2U) << "the wall is as it was";
}

TEST(FurnitureFronts, WhatIsSeenAsHighAsTheWallsIsAWall) {
  EXPECT_EQ(NumKept(RoomWith({.top_m = kUsualTop_m})), 3U) << "a shaft";
  EXPECT_EQ(NumKept(RoomWith({.top_m = kUsualTop_m - 0.05})), 3U) << "uneven by a cell";
}

TEST(FurnitureFronts, AreAsDeepAndAsLongAsWardrobesAre) {
  EXPECT_EQ(NumKept(RoomWith({.depth_m = 0.25})), 3U) << "a chimney breast";
  EXPECT_EQ(NumKept(RoomWith({.depth_m = 1.2})), 3U) << "a corner of the room";
  EXPECT_EQ(NumKept(RoomWith({.length_m = 3.6})), 3U) << "a wall of its own";
}

TEST(FurnitureFronts, HideTheWallBehindThem) {
  WallLines walls = RoomWith({});
  walls.profiles[0].is_wall.assign(200, 0);
  EXPECT_EQ(NumKept(walls), 3U) << "nothing says that there is a wall";
}

// Wall cabinets over a counter, seen as high as anything, and the wall between the two.
TEST(FurnitureFronts, NoWallStandsRightBeforeAWallThatWasSeen) {
  const Wardrobe cabinets = {.depth_m = 0.35, .top_m = kUsualTop_m, .hides = false};
  EXPECT_EQ(NumKept(RoomWith(cabinets)), 1U);
  Wardrobe longer = cabinets;
  longer.length_m = 2.9;
  EXPECT_EQ(NumKept(RoomWith(longer)), 1U);
  Wardrobe picture = cabinets;
  picture.depth_m = 0.1;
  EXPECT_EQ(NumKept(RoomWith(picture)), 3U) << "hangs on it";
  Wardrobe corridor = cabinets;
  corridor.depth_m = 0.9;
  EXPECT_EQ(NumKept(RoomWith(corridor)), 3U) << "room for a person between";
}

// In the same line stands a wall of another room.
TEST(FurnitureFronts, LeaveTheOtherWallOfTheirLine) {
  WallLines walls = RoomWith({});
  walls.lines.erase(walls.lines.begin() + 1);
  walls.profiles.erase(walls.profiles.begin() + 1);
  Add({0, 1}, 0.6, {{0, 1.7, 2.0}, {3.5, 4.5}}, walls);
  DropFurniture(kUsualTop_m, walls);
  ASSERT_EQ(walls.lines.size(), 2U);
  const WallProfile& line = walls.profiles[1];
  EXPECT_EQ(line.WallShare(0, 1.7), 0);
  EXPECT_EQ(line.WallShare(3.5, 4.5), 1);
}

TEST(FurnitureFronts, OfNothingThereAreNone) { EXPECT_EQ(NumKept(WallLines()), 0U); }

}  // namespace
}  // namespace deepslam::layout
