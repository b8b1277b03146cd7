#include "deepslam/synth/true_layout.h"

#include <gmock/gmock.h>

#include "deepslam/synth/world.h"
#include "synth/small_world.h"

namespace deepslam::synth {
namespace {

TEST(TrueLayout, WallsRunRoundTheRoomWithItToTheLeft) {
  const Layout layout = TrueLayout(SmallScene());
  ASSERT_EQ(layout.walls.size(), 4U);
  ASSERT_EQ(layout.rooms.size(), 1U);
  EXPECT_NEAR(AreaOf(layout.rooms[0].polygon_m), 16, 1e-9);
  for (const LayoutWall& wall : layout.walls) {
    const Eigen::Vector2d along = (wall.to_m - wall.from_m).normalized();
    const Eigen::Vector2d left(-along.y(), along.x());
    EXPECT_LT(left.dot(wall.from_m), 0);  // the middle of the room is the origin
    EXPECT_EQ(wall.top_m, 2.5);
  }
}

// The gap in the wall's mesh, found again: no part of the wall lies in the opening, and there is
// wall beside it.
TEST(TrueLayout, OpeningsAreWhereTheWallsHaveGaps) {
  SceneDescription scene = SmallScene();
  scene.openings = {
      {0, 0.5, 0.9, 0, 2.05, 1}, {1, 1.0, 1.2, 0.9, 1.1, 2}, {3, 0.7, 1.8, 0, 2.2, 3}};
  const Layout layout = TrueLayout(scene);
  ASSERT_EQ(layout.openings.size(), 3U);
  EXPECT_EQ(layout.openings[0].kind, OpeningKind::kDoor);
  EXPECT_EQ(layout.openings[1].kind, OpeningKind::kWindow);
  EXPECT_EQ(layout.openings[2].kind, OpeningKind::kPassage);
  const Result<World> world = BuildWorld(scene, {{"box", BoxModel()}}, Classes());
  ASSERT_TRUE(world.ok()) << world.error().message;
  for (const LayoutOpening& opening : layout.openings) {
    const Eigen::Vector2d along = (opening.to_m - opening.from_m).normalized();
    const double width_m = (opening.to_m - opening.from_m).norm();
    bool touches = false;
    for (const RoomPart& part : world->room) {
      if (part.surface != RoomSurface::kWall || part.number != opening.wall) continue;
      for (const auto& face : part.mesh.faces) {
        Eigen::Vector3d middle = Eigen::Vector3d::Zero();
        for (const std::uint32_t v : face) middle += part.mesh.vertices[v].cast<double>() / 3;
        const Eigen::Vector2d off = middle.head<2>() - opening.from_m;
        const double at_m = along.dot(off);
        const double beside_m = std::abs(along.x() * off.y() - along.y() * off.x());
        if (beside_m > 1e-3) continue;  // lining
        EXPECT_FALSE(at_m > 0.01 && at_m < width_m - 0.01 && middle.z() > opening.bottom_m + 0.01 &&
                     middle.z() < opening.top_m - 0.01);
        for (const std::uint32_t v : face) {
          const Eigen::Vector3d p = part.mesh.vertices[v].cast<double>();
          touches = touches || ((p.head<2>() - opening.from_m).norm() < 1e-3 &&
                                std::abs(p.z() - opening.top_m) < 1e-3);
        }
      }
    }
    EXPECT_TRUE(touches);
  }
}

// A wall across makes two rooms; its gap is a door between them, seen from either side.
TEST(TrueLayout, APartitionMakesTwoRoomsAndItsGapADoor) {
  SceneDescription scene = SmallScene();
  scene.objects.clear();
  ScenePartition across;
  across.from_m = {0.5, -2};
  across.to_m = {0.5, 2};
  across.openings.push_back({0, 1.0, 0.9, 0, 2.05, 1});
  scene.partitions.push_back(across);
  const Layout layout = TrueLayout(scene);
  ASSERT_EQ(layout.rooms.size(), 2U);
  EXPECT_NEAR(AreaOf(layout.rooms[0].polygon_m) + AreaOf(layout.rooms[1].polygon_m),
              16 - 4 * across.thickness_m,
              1e-9);
  EXPECT_EQ(layout.walls.size(), 8U);
  ASSERT_EQ(layout.openings.size(), 1U);
  const LayoutOpening& door = layout.openings[0];
  EXPECT_EQ(door.kind, OpeningKind::kDoor);
  EXPECT_THAT(door.rooms, testing::UnorderedElementsAre(0, 1));
  EXPECT_NEAR(std::abs(door.from_m.y() - door.to_m.y()), 0.9, 1e-9);
  EXPECT_NEAR(std::min(door.from_m.y(), door.to_m.y()), -1.0, 1e-9);
  const Result<World> world = BuildWorld(scene, {}, Classes());
  ASSERT_TRUE(world.ok()) << world.error().message;
  int num_faces = 0;
  for (const RoomPart& part : world->room) {
    if (part.surface != RoomSurface::kWall || part.number < 4) continue;
    for (const auto& face : part.mesh.faces) {
      ++num_faces;
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      for (const std::uint32_t v : face) middle += part.mesh.vertices[v].cast<double>() / 3;
      EXPECT_FALSE(middle.y() > -0.95 && middle.y() < -0.15 && middle.z() > 0.05 &&
                   middle.z() < 2.0);
    }
  }
  EXPECT_GT(num_faces, 8);
}

TEST(TrueLayout, ALeafFillsAClosedDoor) {
  SceneDescription scene = SmallScene();
  scene.openings = {{0, 0.5, 0.9, 0, 2.05, 1, false}};
  const auto num_faces = [&] {
    const Result<World> world = BuildWorld(scene, {{"box", BoxModel()}}, Classes());
    return world.ok() ? RoomMesh(*world).faces.size() : 0;
  };
  const std::size_t open = num_faces();
  scene.openings[0].closed = true;
  EXPECT_EQ(num_faces(), open + 2);
}

}  // namespace
}  // namespace deepslam::synth
