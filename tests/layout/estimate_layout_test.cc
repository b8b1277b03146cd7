#include "deepslam/layout/estimate_layout.h"
#include "deepslam/core/angles.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/parallel.h"
#include "layout/box_rooms.h"

namespace deepslam::layout {
namespace {

Layout LayoutOf(const std::vector<Cuboid>& world,
                const std::vector<Pose3>& poses,
                double turned_rad = 0) {
  return EstimateLayout(SurfaceOf(world, poses, turned_rad), LayoutOptions());
}

std::vector<Cuboid> OneRoom() {
  std::vector<Cuboid> world;
  AddRoomWalls(-2, -1.5, 2, 1.5, world);
  AddCeiling(-2.2, -1.7, 2.2, 1.7, world);
  return world;
}

std::vector<Pose3> InTheMiddle() {
  std::vector<Pose3> poses;
  LookAround(0.3, 0.2, poses);
  LookAround(-0.6, -0.3, poses);
  return poses;
}

double ToCorner(const LayoutRoom& room, const Eigen::Vector2d& corner) {
  double nearest = 1e9;
  for (const Eigen::Vector2d& p : room.polygon_m) nearest = std::min(nearest, (p - corner).norm());
  return nearest;
}

TEST(EstimateLayout, FindsARoomAtAnyAngle) {
  for (const double angle_deg : {0.0, 17.0, 45.0, 71.5}) {
    const Layout layout = LayoutOf(OneRoom(), InTheMiddle(), angle_deg * kRadPerDeg);
    ASSERT_EQ(layout.rooms.size(), 1U) << angle_deg;
    const LayoutRoom& room = layout.rooms[0];
    EXPECT_EQ(room.polygon_m.size(), 4U) << angle_deg;
    EXPECT_NEAR(AreaOf(room.polygon_m), 12.0, 0.36) << angle_deg;
    EXPECT_NEAR(room.floor_m, 0, 0.03);
    EXPECT_NEAR(room.ceiling_m, kCeiling_m, 0.03);
    const Eigen::Rotation2Dd turn(angle_deg * kRadPerDeg);
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(2, 1.5), Eigen::Vector2d(-2, 1.5)})
      EXPECT_LT(ToCorner(room, turn * corner), 0.05) << angle_deg;
    EXPECT_EQ(layout.walls.size(), 4U) << angle_deg;
    for (const LayoutWall& wall : layout.walls) {
      EXPECT_GT(wall.seen_share, 0.85);
      EXPECT_NEAR(wall.top_m, kCeiling_m, 0.03);
      EXPECT_EQ(wall.rooms, std::vector<int>{0});
    }
    EXPECT_TRUE(layout.openings.empty());
    EXPECT_EQ(std::count(room.guessed.begin(), room.guessed.end(), true), 0);
  }
}

TEST(EstimateLayout, DoesNotDependOnTheNumberOfThreads) {
  const CoarseSurface surface = SurfaceOf(OneRoom(), InTheMiddle());
  const auto with_threads = [&](int num_threads) {
    const ThreadLimit limit(num_threads);
    return EstimateLayout(surface, LayoutOptions());
  };
  EXPECT_EQ(with_threads(1), with_threads(4));
}

// Two rooms with a door between them, and a window in the second.
std::vector<Cuboid> TwoRooms() {
  std::vector<Cuboid> world;
  AddWall({true, 1.5, -2.2, 6.2, 0.2, {{4.0, 5.2, 0.9, 2.1}}}, world);
  AddWall({true, -1.5, -2.2, 6.2, -0.2, {}}, world);
  AddWall({false, -2, -1.5, 1.5, -0.2, {}}, world);
  AddWall({false, 6, -1.5, 1.5, 0.2, {}}, world);
  AddWall({false, 2, -1.5, 1.5, 0.12, {{-0.4, 0.5, 0, 2.05}}}, world);
  AddCeiling(-2.2, -1.7, 6.2, 1.7, world);
  return world;
}

std::vector<Pose3> ThroughTheDoor() {
  std::vector<Pose3> poses = InTheMiddle();
  LookAround(1.3, 0.05, poses);
  LookAround(3.0, 0.05, poses);
  LookAround(4.4, -0.3, poses);
  return poses;
}

TEST(EstimateLayout, TellsTwoRoomsWithADoorBetweenThem) {
  const Layout layout = LayoutOf(TwoRooms(), ThroughTheDoor(), 0.3);
  ASSERT_EQ(layout.rooms.size(), 2U);
  const double a = AreaOf(layout.rooms[0].polygon_m);
  const double b = AreaOf(layout.rooms[1].polygon_m);
  EXPECT_NEAR(std::min(a, b), 3.88 * 3, 0.36);
  EXPECT_NEAR(std::max(a, b), 4 * 3, 0.36);
  std::vector<LayoutOpening> doors;
  std::vector<LayoutOpening> windows;
  for (const LayoutOpening& opening : layout.openings)
    (opening.kind == OpeningKind::kWindow ? windows : doors).push_back(opening);
  ASSERT_EQ(doors.size(), 1U);
  EXPECT_EQ(doors[0].kind, OpeningKind::kDoor);
  EXPECT_NEAR((doors[0].to_m - doors[0].from_m).norm(), 0.9, 0.15);
  EXPECT_NEAR(doors[0].top_m, 2.05, 0.1);
  EXPECT_EQ(doors[0].rooms.size(), 2U);
  EXPECT_GT(doors[0].confidence, 0.6);
  // The window's jambs may be told as a second one beside it.
  ASSERT_FALSE(windows.empty());
  EXPECT_LE(windows.size(), 2U);
  EXPECT_TRUE(std::ranges::any_of(windows, [](const LayoutOpening& window) {
    return std::abs((window.to_m - window.from_m).norm() - 1.2) < 0.15 &&
           std::abs(window.bottom_m - 0.9) < 0.1 && std::abs(window.top_m - 2.1) < 0.1;
  }));
}

// Through the door alone: what is told of the second room lies within it, and says that nobody was
// there.
TEST(EstimateLayout, ARoomThatNobodyEnteredIsToldAsSuch) {
  std::vector<Pose3> poses = InTheMiddle();
  LookAround(1.0, 0.05, poses);
  const Layout layout = LayoutOf(TwoRooms(), poses);
  ASSERT_FALSE(layout.rooms.empty());
  EXPECT_NEAR(AreaOf(layout.rooms[0].polygon_m), 4 * 3, 0.36);
  EXPECT_TRUE(layout.rooms[0].note.empty());
  for (std::size_t room = 1; room < layout.rooms.size(); ++room) {
    EXPECT_FALSE(layout.rooms[room].note.empty());
    EXPECT_LE(layout.rooms[room].confidence, 0.5);
    for (const Eigen::Vector2d& p : layout.rooms[room].polygon_m) {
      EXPECT_GT(p.x(), 1.9);
      EXPECT_LT(p.x(), 6.2);
      EXPECT_LT(std::abs(p.y()), 1.7);
    }
  }
  const auto door = std::ranges::find(layout.openings, OpeningKind::kDoor, &LayoutOpening::kind);
  ASSERT_NE(door, layout.openings.end());
  if (door->rooms.size() == 1) {
    EXPECT_FALSE(door->note.empty());
    EXPECT_FALSE(layout.notes.empty());
  }
}

// However the home lies in its world, it is the same home.
TEST(EstimateLayout, TurnedRoomsHaveTheSameWallsAndOpenings) {
  std::vector<Cuboid> world = TwoRooms();
  AddBox({-2, -1.5, 0}, {-1.4, -0.6, 1.8}, world);   // a wardrobe
  AddBox({4.2, -1.5, 0}, {5.8, -0.7, 0.75}, world);  // a table at a wall
  const Layout straight = LayoutOf(world, ThroughTheDoor());
  ASSERT_EQ(straight.rooms.size(), 2U);
  for (const double angle_deg : {17.0, 90.0, 133.0}) {
    const Eigen::Rotation2Dd turn(angle_deg * kRadPerDeg);
    const Layout turned = LayoutOf(world, ThroughTheDoor(), angle_deg * kRadPerDeg);
    ASSERT_EQ(turned.rooms.size(), straight.rooms.size()) << angle_deg;
    EXPECT_EQ(turned.walls.size(), straight.walls.size()) << angle_deg;
    for (const LayoutRoom& room : straight.rooms) {
      double nearest_m = 1e9;
      for (const LayoutRoom& other : turned.rooms) {
        double farthest_m = 0;
        for (const Eigen::Vector2d& corner : room.polygon_m)
          farthest_m = std::max(farthest_m, ToCorner(other, turn * corner));
        nearest_m = std::min(nearest_m, farthest_m);
      }
      EXPECT_LT(nearest_m, 0.05) << angle_deg;
    }
    // A door between two rooms is told on one of the two faces of its wall.
    constexpr double kFaces_m = 0.16;
    const auto middle = [](const LayoutOpening& opening) -> Eigen::Vector2d {
      return 0.5 * (opening.from_m + opening.to_m);
    };
    EXPECT_EQ(turned.openings.size(), straight.openings.size()) << angle_deg;
    for (const LayoutOpening& opening : straight.openings) {
      EXPECT_TRUE(std::ranges::any_of(turned.openings, [&](const LayoutOpening& other) {
        return other.kind == opening.kind &&
               (middle(other) - turn * middle(opening)).norm() < kFaces_m &&
               std::abs(other.top_m - opening.top_m) < 0.12;
      })) << angle_deg;
    }
  }
}

// Two rooms in one line along a facade: each has a wall of its own, and no third one spans both.
TEST(EstimateLayout, AWallOfTwoRoomsIsNotToldOnceMore) {
  const Layout layout = LayoutOf(TwoRooms(), ThroughTheDoor());
  EXPECT_EQ(layout.walls.size(), 8U);
  for (const LayoutWall& wall : layout.walls) EXPECT_EQ(wall.rooms.size(), 1U);
}

TEST(EstimateLayout, FurnitureIsNoWall) {
  std::vector<Cuboid> world = OneRoom();
  AddBox({-2, -1.5, 0}, {-1.4, 0, 2.0}, world);      // a wardrobe in the corner
  AddBox({0.5, 0.9, 0}, {2, 1.5, 0.9}, world);       // a counter
  AddBox({0.0, -1.5, 0}, {1.2, -0.9, 0.75}, world);  // a desk
  AddBox({-0.8, 1.2, 1.4}, {0.4, 1.5, 2.1}, world);  // a wall cabinet
  const Layout layout = LayoutOf(world, InTheMiddle());
  ASSERT_EQ(layout.rooms.size(), 1U);
  EXPECT_NEAR(AreaOf(layout.rooms[0].polygon_m), 12.0, 0.36);
  EXPECT_EQ(layout.walls.size(), 4U);
}

// No ceiling is seen. The camera looks down at the end with the wardrobe, whose sides are seen less
// high than the walls elsewhere.
TEST(EstimateLayout, SidesOfAWardrobeAreNoWallsWhereNoCeilingWasSeen) {
  std::vector<Cuboid> world;
  AddRoomWalls(-3, -1.5, 3, 1.5, world);
  AddBox({-3, -1.5, 0}, {-2, -0.5, 1.9}, world);
  std::vector<Pose3> poses;
  for (int n = 0; n < 24; ++n) {
    const double angle = 2 * std::numbers::pi * n / 24;
    const bool at_wardrobe = std::cos(angle) < 0;
    const Eigen::Vector3d from(at_wardrobe ? -1.2 : 0.6, 0.5, 1.5);
    const double down_m = at_wardrobe ? 1.1 : 0.2;
    poses.push_back(testing_support::LookAt(
        from, from + Eigen::Vector3d(2 * std::cos(angle), 2 * std::sin(angle), -down_m)));
  }
  const Layout layout = LayoutOf(world, poses);
  for (const LayoutWall& wall : layout.walls) {
    const Eigen::Vector2d middle = 0.5 * (wall.from_m + wall.to_m);
    EXPECT_GT(std::max(std::abs(middle.x()) / 3, std::abs(middle.y()) / 1.5), 0.95)
        << "at " << middle.transpose() << ", seen up to " << wall.top_m << " m";
  }
  EXPECT_GE(layout.walls.size(), 3U);
}

// The camera looks up to 2 m at the wardrobe, which is higher, and up to the ceiling elsewhere.
TEST(EstimateLayout, AWardrobeThatNobodyLookedOverIsNoWall) {
  std::vector<Cuboid> world = OneRoom();
  AddBox({-2, -0.8, 0}, {-1.4, 0.9, 2.1}, world);
  std::vector<Pose3> poses;
  for (const double y : {-1.1, 1.1}) {
    for (int n = 0; n < 16; ++n) {
      const double angle = 2 * std::numbers::pi * n / 16;
      const Eigen::Vector3d from(0.4, y, 1.5);
      for (const double up : {-0.8, std::cos(angle) < 0.3 ? -0.2 : 0.3})
        poses.push_back(testing_support::LookAt(
            from, from + Eigen::Vector3d(std::cos(angle), std::sin(angle), up)));
    }
  }
  const Layout layout = LayoutOf(world, poses);
  EXPECT_EQ(layout.walls.size(), 4U);
  ASSERT_EQ(layout.rooms.size(), 1U);
  EXPECT_NEAR(AreaOf(layout.rooms[0].polygon_m), 12.0, 0.36);
}

TEST(EstimateLayout, WithoutWallsThereIsNoRoom) {
  std::vector<Cuboid> world;
  testing_support::Append(world, testing_support::TableAt(-1, 1.5, 0));
  const Layout layout = LayoutOf(world, InTheMiddle());
  EXPECT_TRUE(layout.rooms.empty());
  EXPECT_TRUE(layout.walls.empty());
  EXPECT_TRUE(layout.openings.empty());
  EXPECT_FALSE(layout.notes.empty());
}

TEST(EstimateLayout, OfNothingIsEmpty) {
  const Layout layout = EstimateLayout(CoarseSurface(), LayoutOptions());
  EXPECT_TRUE(layout.rooms.empty());
  EXPECT_TRUE(layout.walls.empty());
  EXPECT_FALSE(layout.notes.empty());
}

TEST(EstimateLayout, OneWallIsOneWall) {
  std::vector<Cuboid> world;
  AddWall({true, 1.5, -2, 2, 0.2, {}}, world);
  std::vector<Pose3> poses;
  for (const double x : {-0.8, 0.0, 0.8}) {
    for (const double z : {0.5, 1.5, 2.4})
      poses.push_back(testing_support::LookAt({x, -0.8, 1.5}, {x, 1.5, z}));
  }
  const Layout layout = LayoutOf(world, poses);
  ASSERT_EQ(layout.walls.size(), 1U);
  const Eigen::Vector2d along = (layout.walls[0].to_m - layout.walls[0].from_m).normalized();
  EXPECT_NEAR(std::abs(along.x()), 1, 0.001);
  EXPECT_NEAR(layout.walls[0].from_m.y(), 1.5, 0.03);
  for (const LayoutRoom& room : layout.rooms)
    EXPECT_GE(std::count(room.guessed.begin(), room.guessed.end(), true), 2);
}

TEST(EstimateLayout, TheEndsOfAHallThatWereNotSeenAreGuessed) {
  std::vector<Cuboid> world;
  AddWall({true, 1.2, -20, 20, 0.2, {}}, world);
  AddWall({true, -1.2, -20, 20, -0.2, {}}, world);
  AddCeiling(-20, -1.4, 20, 1.4, world);
  const Layout layout = LayoutOf(world, InTheMiddle());
  ASSERT_EQ(layout.rooms.size(), 1U);
  const LayoutRoom& room = layout.rooms[0];
  EXPECT_EQ(std::count(room.guessed.begin(), room.guessed.end(), false), 2);
  EXPECT_GE(std::count(room.guessed.begin(), room.guessed.end(), true), 2);
  // As far as was looked, and no further.
  EXPECT_LT(AreaOf(room.polygon_m), 2.4 * 14.1);
  for (const LayoutWall& wall : layout.walls) EXPECT_LT(wall.length_m(), 14.1);
}

TEST(EstimateLayout, WithoutAGroundThereAreWallsButNoRooms) {
  CoarseSurface surface = SurfaceOf(OneRoom(), InTheMiddle());
  surface.has_ground = false;
  const Layout layout = EstimateLayout(surface, LayoutOptions());
  EXPECT_TRUE(layout.rooms.empty());
  EXPECT_EQ(layout.walls.size(), 4U);
  for (const LayoutWall& wall : layout.walls) EXPECT_LT(wall.confidence, 0.5);
}

}  // namespace
}  // namespace deepslam::layout
