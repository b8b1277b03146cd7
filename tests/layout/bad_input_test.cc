// What is no room, or is not seen as one: a layout that claims less, never nonsense.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "deepslam/layout/estimate_layout.h"
#include "layout/box_rooms.h"

namespace deepslam::layout {
namespace {

std::vector<Cuboid> Room() {
  std::vector<Cuboid> world;
  AddRoomWalls(-2, -1.5, 2, 1.5, world);
  AddCeiling(-2.2, -1.7, 2.2, 1.7, world);
  return world;
}

std::vector<Pose3> Views() {
  std::vector<Pose3> poses;
  LookAround(0.3, 0.2, poses);
  LookAround(-0.6, -0.3, poses);
  return poses;
}

// A plane over [-2, 2] x [-1.5, 1.5] that rises along y, seen from below.
void AddSlope(double low_m, double rise, CoarseSurface& surface) {
  constexpr double kStep_m = 0.04;
  const Eigen::Vector3f normal = Eigen::Vector3d(0, rise, -1).normalized().cast<float>();
  const auto first = static_cast<std::uint32_t>(surface.mesh.vertices.size());
  constexpr std::uint32_t kAcross = 101;
  constexpr std::uint32_t kAlong = 76;
  for (std::uint32_t j = 0; j < kAlong; ++j) {
    for (std::uint32_t i = 0; i < kAcross; ++i) {
      const double x = -2 + kStep_m * i;
      const double y = -1.5 + kStep_m * j;
      surface.mesh.vertices.emplace_back(
          Eigen::Vector3d(x, y, low_m + rise * (y + 1.5)).cast<float>());
      surface.normals.push_back(normal);
      surface.num_frames.push_back(5);
      if (!surface.mesh.colours.empty()) surface.mesh.colours.push_back({90, 90, 90});
    }
  }
  for (std::uint32_t j = 0; j + 1 < kAlong; ++j) {
    for (std::uint32_t i = 0; i + 1 < kAcross; ++i) {
      const std::uint32_t a = first + j * kAcross + i;
      surface.mesh.faces.push_back({a, a + kAcross, a + 1});
      surface.mesh.faces.push_back({a + 1, a + kAcross, a + kAcross + 1});
    }
  }
}

TEST(BadInput, SlantedRoofsAreToldAsWhatTheyAre) {
  std::vector<Cuboid> world;
  AddRoomWalls(-2, -1.5, 2, 1.5, world);
  for (const double rise : {0.4, 1.0, 2.0}) {
    CoarseSurface surface = SurfaceOf(world, Views());
    AddSlope(1.0, rise, surface);
    const Layout layout = EstimateLayout(surface, LayoutOptions());
    ASSERT_FALSE(layout.slanted.empty()) << rise;
    const Eigen::Vector3d normal = Eigen::Vector3d(0, rise, -1).normalized();
    EXPECT_GT(layout.slanted[0].plane.normal.dot(normal), 0.99) << rise;
    EXPECT_GT(layout.slanted[0].area_m2, 6) << rise;
    // No wall but the four, all upright where they stand.
    EXPECT_LE(layout.walls.size(), 4U) << rise;
    for (const LayoutWall& wall : layout.walls) {
      const double x = std::abs(0.5 * (wall.from_m.x() + wall.to_m.x()));
      const double y = std::abs(0.5 * (wall.from_m.y() + wall.to_m.y()));
      EXPECT_TRUE(std::abs(x - 2) < 0.05 || std::abs(y - 1.5) < 0.05) << rise;
    }
  }
}

// The ground taken for another plane: everything leans.
TEST(BadInput, UnderAWrongGroundWallsAreNotBentUpright) {
  CoarseSurface surface = SurfaceOf(Room(), Views());
  const Eigen::AngleAxisf lean(20 * std::numbers::pi_v<float> / 180, Eigen::Vector3f::UnitX());
  for (Eigen::Vector3f& p : surface.mesh.vertices) p = lean * p;
  for (Eigen::Vector3f& n : surface.normals) n = lean * n;
  for (Eigen::Vector3f& p : surface.viewpoints) p = lean * p;
  surface.space = {};
  const Layout layout = EstimateLayout(surface, LayoutOptions());
  for (const LayoutWall& wall : layout.walls) {
    const Eigen::Vector2d along = (wall.to_m - wall.from_m).normalized();
    EXPECT_GT(std::abs(along.y()), 0.9) << "only what turns about the axis stays upright";
  }
  EXPECT_FALSE(layout.slanted.empty());
  for (const LayoutRoom& room : layout.rooms)
    EXPECT_GE(std::count(room.guessed.begin(), room.guessed.end(), true), 2);
}

TEST(BadInput, BehindAMirrorThereIsNoRoom) {
  std::vector<Cuboid> room;
  AddWall({true, 1.5, -2.2, 2.2, 0.2, {}}, room);
  AddWall({true, -1.5, -2.2, 2.2, -0.2, {}}, room);
  AddWall({false, -2, -1.7, 1.7, -0.2, {}}, room);
  AddCeiling(-2.2, -1.7, 2.2, 1.7, room);
  AddBox({-1.9, -1.4, 0}, {-1.2, -0.6, 1.1}, room);
  std::vector<Cuboid> world = room;
  // The mirror is a hole in the wall at x = 2, behind which all is there again.
  AddWall({false, 2, -1.7, 1.7, 0.02, {{-0.8, 0.8, 0.1, 2.0}}}, world);
  for (const Cuboid& box : room) {
    AddBox({4 - box.max_m.x(), box.min_m.y(), box.min_m.z()},
           {4 - box.min_m.x(), box.max_m.y(), box.max_m.z()},
           world);
  }
  const Layout layout = EstimateLayout(SurfaceOf(world, Views()), LayoutOptions());
  ASSERT_EQ(layout.rooms.size(), 1U);
  EXPECT_NEAR(AreaOf(layout.rooms[0].polygon_m), 12, 0.4);
  for (const LayoutOpening& opening : layout.openings) EXPECT_EQ(opening.rooms.size(), 1U);
  for (const LayoutWall& wall : layout.walls) EXPECT_LT(wall.from_m.x(), 2.2) << "an image";
}

TEST(BadInput, BehindAWindowThereIsNoRoom) {
  std::vector<Cuboid> world;
  AddWall({true, 1.5, -2.2, 2.2, 0.2, {}}, world);
  AddWall({true, -1.5, -2.2, 2.2, -0.2, {}}, world);
  AddWall({false, -2, -1.7, 1.7, -0.2, {}}, world);
  AddWall({false, 2, -1.7, 1.7, 0.2, {{-0.7, 0.7, 0.9, 2.1}}}, world);
  AddCeiling(-2.2, -1.7, 2.2, 1.7, world);
  AddBox({5.5, -6, 0}, {5.7, 6, 3}, world);  // the house across the street
  const Layout layout = EstimateLayout(SurfaceOf(world, Views()), LayoutOptions());
  ASSERT_EQ(layout.rooms.size(), 1U);
  EXPECT_NEAR(AreaOf(layout.rooms[0].polygon_m), 12, 0.4);
  ASSERT_EQ(layout.openings.size(), 1U);
  EXPECT_EQ(layout.openings[0].kind, OpeningKind::kWindow);
}

TEST(BadInput, OutdoorsThereAreNoRooms) {
  std::vector<Cuboid> world;
  AddBox({2.5, -0.3, 0}, {2.8, 0, 3.5}, world);  // trunks of trees
  AddBox({-1.2, 2.0, 0}, {-0.9, 2.3, 3.5}, world);
  AddBox({-3, -2.5, 0}, {-1, -1.9, 0.9}, world);  // a hedge
  AddBox({1, 2.5, 0}, {2.6, 3.6, 1.3}, world);    // a car
  const Layout layout = EstimateLayout(SurfaceOf(world, Views()), LayoutOptions());
  EXPECT_TRUE(layout.rooms.empty());
  EXPECT_TRUE(layout.walls.empty());
  EXPECT_TRUE(layout.openings.empty());
  EXPECT_FALSE(layout.notes.empty());
}

}  // namespace
}  // namespace deepslam::layout
