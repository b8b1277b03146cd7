#include "deepslam/layout/relations.h"

#include <limits>

#include <gtest/gtest.h>

namespace deepslam::layout {
namespace {

// Two rooms of 4 x 3 m beside each other; the floor of the second is a step higher.
Layout TwoRooms() {
  Layout layout;
  for (const double x : {0.0, 4.2}) {
    LayoutRoom room;
    room.polygon_m = {{x, 0}, {x + 4, 0}, {x + 4, 3}, {x, 3}};
    room.guessed.assign(4, false);
    room.floor_m = x > 0 ? 0.3 : 0;
    const int id = static_cast<int>(layout.rooms.size());
    layout.rooms.push_back(room);
    for (std::size_t n = 0; n < 4; ++n) {
      LayoutWall wall;
      wall.from_m = room.polygon_m[n];
      wall.to_m = room.polygon_m[(n + 1) % 4];
      wall.bottom_m = room.floor_m;
      wall.top_m = 2.5;
      wall.rooms = {id};
      layout.walls.push_back(wall);
    }
  }
  return layout;
}

ThingBox BoxAt(const Eigen::Vector3d& middle, const Eigen::Vector3d& size, double turned_deg = 0) {
  const double rad = turned_deg * 3.14159265358979 / 180;
  return {{Eigen::Quaterniond(Eigen::AngleAxisd(rad, Eigen::Vector3d::UnitZ())), middle}, size};
}

TEST(RelationsOf, NamesTheRoomAndWhatAThingStandsOn) {
  const std::vector<ThingBox> things = {
      BoxAt({2, 1.5, 0.37}, {1.2, 0.8, 0.74}, 33),  // a table in the middle of the first room
      BoxAt({2, 1.5, 0.84}, {0.2, 0.2, 0.2}),       // a vase on it
      BoxAt({6.2, 1.5, 0.7}, {0.5, 0.5, 0.8}),      // a chair on the second room's floor
      BoxAt({20, 1.5, 0.4}, {0.5, 0.5, 0.8}),       // in no room
      BoxAt({2, 1.5, 1.9}, {0.3, 0.3, 0.3})};       // in the air
  const std::vector<Relations> relations = RelationsOf(TwoRooms(), things);
  ASSERT_EQ(relations.size(), 5U);
  EXPECT_EQ(relations[0].room, 0);
  EXPECT_EQ(relations[0].support, Support::kFloor);
  EXPECT_FALSE(relations[0].against_wall.has_value());
  EXPECT_EQ(relations[1].support, Support::kThing);
  EXPECT_EQ(relations[1].on, 0U);
  EXPECT_EQ(relations[2].room, 1);
  EXPECT_EQ(relations[2].support, Support::kFloor);
  EXPECT_FALSE(relations[3].room.has_value());
  EXPECT_EQ(relations[3].support, Support::kFloor);
  EXPECT_EQ(relations[4].support, Support::kUnknown);
  EXPECT_FALSE(relations[4].on.has_value());
}

TEST(RelationsOf, AThingAtAWallTouchesItWithASide) {
  const std::vector<ThingBox> things = {
      BoxAt({1, 0.25, 0.5}, {0.8, 0.4, 1.0}),      // 5 cm before the first wall
      BoxAt({1, 0.30, 0.5}, {0.4, 0.8, 1.0}, 90),  // the same, turned by a quarter
      BoxAt({1, 0.35, 0.5}, {0.8, 0.4, 1.0}, 45),  // a corner towards it
      BoxAt({1, 1.0, 0.5}, {0.8, 0.4, 1.0}),       // 80 cm off
      BoxAt({1, 0.05, 1.6}, {0.6, 0.08, 0.5})};    // a picture on it
  const std::vector<Relations> relations = RelationsOf(TwoRooms(), things);
  EXPECT_EQ(relations[0].against_wall, 0);
  EXPECT_EQ(relations[1].against_wall, 0);
  EXPECT_FALSE(relations[2].against_wall.has_value());
  EXPECT_FALSE(relations[3].against_wall.has_value());
  EXPECT_EQ(relations[4].against_wall, 0);
  EXPECT_EQ(relations[4].support, Support::kWall);
  EXPECT_EQ(relations[0].support, Support::kFloor);
}

// Things mirrored and the layout mirrored with them: the same words.
TEST(RelationsOf, DoNotDependOnWhereTheOriginIs) {
  Layout layout = TwoRooms();
  std::vector<ThingBox> things = {BoxAt({1, 0.25, 0.5}, {0.8, 0.4, 1.0}),
                                  BoxAt({1, 0.25, 1.1}, {0.2, 0.2, 0.2})};
  const std::vector<Relations> before = RelationsOf(layout, things);
  const Eigen::Vector2d shift(17, -9);
  for (LayoutRoom& room : layout.rooms) {
    for (Eigen::Vector2d& p : room.polygon_m) p += shift;
  }
  for (LayoutWall& wall : layout.walls) {
    wall.from_m += shift;
    wall.to_m += shift;
  }
  for (ThingBox& thing : things) thing.world_from_object.translation_m.head<2>() += shift;
  const std::vector<Relations> after = RelationsOf(layout, things);
  for (std::size_t n = 0; n < things.size(); ++n) {
    EXPECT_EQ(before[n].room, after[n].room);
    EXPECT_EQ(before[n].support, after[n].support);
    EXPECT_EQ(before[n].on, after[n].on);
    EXPECT_EQ(before[n].against_wall, after[n].against_wall);
  }
}

TEST(RelationsOf, OfAnEmptyLayoutAndABoxWithoutSizeClaimLittle) {
  const std::vector<Relations> relations =
      RelationsOf(Layout(), {BoxAt({0, 0, 1}, {0, 0, 0}), BoxAt({0, 0, 1}, {0, 0, 0})});
  ASSERT_EQ(relations.size(), 2U);
  EXPECT_FALSE(relations[0].room.has_value());
  EXPECT_FALSE(relations[0].against_wall.has_value());
  EXPECT_TRUE(RelationsOf(TwoRooms(), {}).empty());
}

}  // namespace
}  // namespace deepslam::layout
