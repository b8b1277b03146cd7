#include "deepslam/layout/carry_layout.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace deepslam::layout {
namespace {

// A room of 4 x 3 m with a door in its first wall, and the slope of a roof over it.
Layout RoomWithDoor() {
  Layout layout;
  LayoutRoom room;
  room.polygon_m = {{0, 0}, {4, 0}, {4, 3}, {0, 3}};
  room.guessed = {false, false, false, true};
  room.ceiling_m = 2.5;
  layout.rooms = {room};
  for (std::size_t n = 0; n < 4; ++n) {
    LayoutWall wall;
    wall.from_m = room.polygon_m[n];
    wall.to_m = room.polygon_m[(n + 1) % 4];
    wall.top_m = 2.5;
    wall.rooms = {0};
    layout.walls.push_back(wall);
  }
  LayoutOpening door;
  door.wall = 0;
  door.from_m = {1, 0};
  door.to_m = {1.9, 0};
  door.top_m = 2.0;
  door.rooms = {0};
  layout.openings = {door};
  layout.slanted = {{{Eigen::Vector3d(0.6, 0, -0.8), 1.0}, {1, 1, 2}, 2.0}};
  layout.slanted[0].plane.d_m = -layout.slanted[0].plane.normal.dot(layout.slanted[0].centre_m);
  return layout;
}

Pose3 Turned(double angle_rad, const Eigen::Vector3d& by_m) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ())), by_m};
}

std::vector<MovedCamera> Cameras(const Pose3& world_from_level) {
  std::vector<MovedCamera> cameras;
  for (const double x : {0.5, 2.0, 3.5}) {
    const Pose3 level_from_camera{Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {x, 1.5, 1.4}};
    cameras.push_back({level_from_camera, world_from_level * level_from_camera});
  }
  return cameras;
}

TEST(CarryLayout, WithoutCamerasItStaysWhereItIs) {
  Layout layout = RoomWithDoor();
  layout.level_from_tracking = Turned(0.4, {1, 2, 3});
  const Layout carried = CarryLayout(layout, {});
  layout.level_from_tracking = Pose3();
  EXPECT_EQ(carried, layout);
}

TEST(CarryLayout, MovesAsOneWhereAllCamerasDid) {
  const Pose3 moved = Turned(0.7, {0.3, -2, 0.05});
  const Layout before = RoomWithDoor();
  const Layout after = CarryLayout(before, Cameras(moved));
  const auto there = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2d((moved * Eigen::Vector3d(p.x(), p.y(), 0)).head<2>());
  };
  for (std::size_t n = 0; n < 4; ++n) {
    EXPECT_LT((after.rooms[0].polygon_m[n] - there(before.rooms[0].polygon_m[n])).norm(), 1e-9);
    EXPECT_LT((after.walls[n].from_m - there(before.walls[n].from_m)).norm(), 1e-9);
    EXPECT_NEAR(after.walls[n].top_m, 2.55, 1e-9);
  }
  EXPECT_NEAR(after.rooms[0].floor_m, 0.05, 1e-9);
  EXPECT_NEAR(after.rooms[0].ceiling_m, 2.55, 1e-9);
  EXPECT_LT((after.openings[0].to_m - there(before.openings[0].to_m)).norm(), 1e-9);
  EXPECT_LT((after.slanted[0].centre_m - moved * before.slanted[0].centre_m).norm(), 1e-9);
  EXPECT_LT(
      (after.slanted[0].plane.normal - moved.rotation * before.slanted[0].plane.normal).norm(),
      1e-9);
  EXPECT_NEAR(
      after.slanted[0].plane.normal.dot(after.slanted[0].centre_m) + after.slanted[0].plane.d_m,
      0,
      1e-9);
}

TEST(CarryLayout, AWallFollowsTheCamerasNearItAndKeepsItsOpenings) {
  std::vector<MovedCamera> cameras = Cameras(Pose3());
  // Far off, another camera drifted by half a metre.
  MovedCamera far = cameras[0];
  far.level_from_camera.translation_m = {30, 1.5, 1.4};
  far.world_from_camera = far.level_from_camera;
  far.world_from_camera.translation_m.y() += 0.5;
  cameras.push_back(far);
  Layout layout = RoomWithDoor();
  LayoutWall there = layout.walls[0];
  there.from_m = {28, 0};
  there.to_m = {32, 0};
  layout.walls.push_back(there);
  // A long wall from here to there is turned.
  LayoutWall between = layout.walls[0];
  between.to_m = {30, 0};
  layout.walls.push_back(between);
  layout.openings[0].wall = 5;
  const Layout carried = CarryLayout(layout, cameras);
  EXPECT_LT((carried.walls[0].from_m - layout.walls[0].from_m).norm(), 0.01);
  EXPECT_NEAR(carried.walls[4].from_m.y(), 0.5, 0.01);
  EXPECT_NEAR(carried.walls[4].to_m.y(), 0.5, 0.01);
  const LayoutWall& wall = carried.walls[5];
  const Eigen::Vector2d along = (wall.to_m - wall.from_m).normalized();
  for (const Eigen::Vector2d& end : {carried.openings[0].from_m, carried.openings[0].to_m}) {
    const Eigen::Vector2d off = end - wall.from_m;
    EXPECT_NEAR(along.x() * off.y() - along.y() * off.x(), 0, 1e-9);
  }
}

TEST(CarryLayout, ACeilingThatWasNotSeenStaysSo) {
  Layout layout = RoomWithDoor();
  layout.rooms[0].ceiling_m = 0;
  EXPECT_EQ(CarryLayout(layout, Cameras(Turned(0, {0, 0, 0.2}))).rooms[0].ceiling_m, 0);
}

}  // namespace
}  // namespace deepslam::layout
