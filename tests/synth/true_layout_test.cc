#include "deepslam/synth/true_layout.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace deepslam::synth
