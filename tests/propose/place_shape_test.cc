#include "deepslam/propose/place_shape.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/propose/proposer.h"
#include "propose/staged_views.h"

namespace deepslam::propose {
namespace {

using testing_support::Stage;
using testing_support::StagedViews;
using testing_support::StagedWorldFromLevel;

// 40 x 40 x 60 voxels in the middle of the cube: a nightstand, alike from four sides.
VoxelGrid Block() {
  VoxelGrid grid;
  for (int i = 12; i < 52; ++i) {
    for (int j = 12; j < 52; ++j) {
      for (int k = 2; k < 62; ++k) grid.occupied[VoxelGrid::Index(i, j, k)] = 1;
    }
  }
  return grid;
}

const Eigen::Vector3d kSize_m(0.4, 0.4, 0.6);

Stage Standing() {
  Stage stage;
  stage.size_m = kSize_m.z();
  return stage;
}

// With one wall, 3 cm behind the block whose front is turned to this azimuth.
Layout WallBehind(const Stage& stage, double azimuth_rad) {
  const Eigen::Vector2d front(std::cos(azimuth_rad), std::sin(azimuth_rad));
  const Eigen::Vector2d along(front.y(), -front.x());  // with the room on its left
  const Eigen::Vector2d foot_m = stage.place_m - (0.5 * kSize_m.x() + 0.03) * front;
  LayoutWall wall;
  wall.from_m = foot_m - 2 * along;
  wall.to_m = foot_m + 2 * along;
  wall.top_m = 2.5;
  Layout layout;
  layout.level_from_tracking = StagedWorldFromLevel().Inverse();
  layout.walls.push_back(wall);
  return layout;
}

// Cosine of the angle between the placed block's front and an azimuth of the staged level.
double FrontAlong(double azimuth_rad, const Layout* layout, bool has_front) {
  const std::vector<ObjectView> views = StagedViews(Block(), Standing());
  ObjectObservations object{ObjectId{0}, "cabinet", views};
  object.layout = layout;
  const MeasuredDepth measured = MeasureDepth(object, has_front, 6);
  const PlacedShape placed = PlaceShape(CoarseShape(Block()), kSize_m, measured, {});
  EXPECT_GT(placed.score, 0.5);
  const Eigen::Vector3d front_cloud(
      std::cos(placed.placement.yaw_rad), std::sin(placed.placement.yaw_rad), 0);
  const Eigen::Quaterniond staged_from_cloud = StagedWorldFromLevel().rotation.conjugate() *
                                               measured.cloud.level_from_world.rotation.conjugate();
  return (staged_from_cloud * front_cloud)
      .dot(Eigen::Vector3d(std::cos(azimuth_rad), std::sin(azimuth_rad), 0));
}

TEST(PlaceShape, TurnsTheBackToTheWallWhereverThatStands) {
  int num_by_depth_alone = 0;
  for (int n = 0; n < 4; ++n) {
    const double azimuth_rad = Standing().yaw_rad + 0.5 * std::numbers::pi * n;
    const Layout layout = WallBehind(Standing(), azimuth_rad);
    EXPECT_GT(FrontAlong(azimuth_rad, &layout, true), 0.95) << n;
    num_by_depth_alone += FrontAlong(azimuth_rad, &layout, false) > 0.95 ? 1 : 0;
  }
  EXPECT_LE(num_by_depth_alone, 1) << "what has no front stands as the depth says";
}

}  // namespace
}  // namespace deepslam::propose
