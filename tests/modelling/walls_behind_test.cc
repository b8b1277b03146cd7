#include "deepslam/modelling/walls_behind.h"

#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/scene/voxel_grid.h"
#include "support/voxel_shapes.h"

namespace deepslam::modelling {
namespace {

// A box as large as a model can be, 1 m long and high and 0.5 m wide, and a wall of 4 m along x at
// y = 0, whose room is at y > 0. The level world is turned against the tracking's.
class WallsBehindTest : public testing::Test {
 protected:
  WallsBehindTest()
      : model_(testing_support::FillGrid([](double x, double y, double z) {
          const double half = 0.5 * kModelExtent * kGridSize;
          return std::abs(x) < half && std::abs(y) < half / 2 && std::abs(z) < half;
        })) {
    LayoutWall wall;
    wall.to_m = {4, 0};
    wall.top_m = 2.5;
    layout_.walls.push_back(wall);
    layout_.level_from_tracking =
        Pose3(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())),
              Eigen::Vector3d(0.3, -0.2, 1.5));
  }

  // Both in the level world.
  std::vector<Plane> Behind(const Eigen::Vector3d& box_m, const Eigen::Vector3d& camera_m) {
    const Pose3 tracking_from_level = layout_.level_from_tracking.Inverse();
    views_.resize(1);
    views_[0].world_from_camera.translation_m = tracking_from_level * camera_m;
    world_from_object_ = tracking_from_level *
                         Similarity3::From(Pose3(Eigen::Quaterniond::Identity(), box_m), kScale_m);
    return WallsBehind(layout_, model_, world_from_object_, views_);
  }

  static constexpr double kScale_m = 1 / kModelExtent;
  shape::ShapeModel model_;
  Layout layout_;
  std::vector<ObjectView> views_;
  Similarity3 world_from_object_;
};

TEST_F(WallsBehindTest, TheFaceBehindABoxThatCrossesIt) {
  const std::vector<Plane> walls = Behind({2, 0.1, 0.5}, {2, 3, 1.5});
  ASSERT_EQ(walls.size(), 1U);
  // A point of the face's room is before it, one 5 cm behind the face is behind it.
  const Similarity3 object_from_level =
      (layout_.level_from_tracking * world_from_object_).Inverse();
  EXPECT_NEAR(walls[0].normal.norm(), 1, 1e-9);
  EXPECT_GT(walls[0].SignedDistance(object_from_level * Eigen::Vector3d(1, 0, 1)), 0);
  EXPECT_LT(walls[0].SignedDistance(object_from_level * Eigen::Vector3d(3, -0.05, 0.2)), 0);
}

TEST_F(WallsBehindTest, NoneWhereTheBoxIsBeforeItOrBesideIt) {
  const Eigen::Vector3d camera_m(2, 3, 1.5);
  EXPECT_TRUE(Behind({2, 0.4, 0.5}, camera_m).empty()) << "it does not reach the wall";
  EXPECT_TRUE(Behind({2, -1, 0.5}, camera_m).empty()) << "all of it is in the next room";
  EXPECT_TRUE(Behind({4.2, 0.1, 0.5}, camera_m).empty()) << "most of it is beside the wall's end";
  EXPECT_TRUE(Behind({2, 0.1, 3.5}, camera_m).empty()) << "it is above the wall";
}

TEST_F(WallsBehindTest, NoneWhereACameraStoodBehindIt) {
  EXPECT_TRUE(Behind({2, 0.1, 0.5}, {2, -3, 1.5}).empty());
}

TEST_F(WallsBehindTest, NoneOfAnEmptyModelOrOfAWallWithoutLength) {
  layout_.walls[0].to_m = layout_.walls[0].from_m;
  EXPECT_TRUE(Behind({0, 0.1, 0.5}, {2, 3, 1.5}).empty());
  EXPECT_TRUE(
      WallsBehind(layout_, shape::ShapeModel(VoxelGrid()), world_from_object_, views_).empty());
}

}  // namespace
}  // namespace deepslam::modelling
