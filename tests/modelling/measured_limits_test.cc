#include "deepslam/modelling/measured_limits.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "support/furniture_world.h"

namespace deepslam::modelling {
namespace {

using namespace testing_support;  // NOLINT(google-build-using-namespace)

const std::vector<double> kAllRound = {0, 1, 2, 3, 4, 5, 6};

// Of a point within all sides; metres.
double Least(const std::vector<Plane>& sides, const Eigen::Vector3d& p, double scale_m) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const Plane& side : sides) least_m = std::min(least_m, scale_m * side.SignedDistance(p));
  return least_m;
}

TEST(MeasuredLimits, LieOnTheThingsFacesWhereverItStands) {
  for (const double yaw_rad : {0.0, 0.7, 2.5}) {
    const FurnitureWorld world(TableGrid(), 1.6, yaw_rad);
    const std::vector<Plane> sides =
        MeasuredLimits(world.world_from_object(), world.Views(kAllRound), false).sides;
    ASSERT_EQ(sides.size(), 5U);
    const double scale_m = world.world_from_object().scale;
    const Eigen::Vector3d low = world.model().box_min().cast<double>();
    const Eigen::Vector3d high = world.model().box_max().cast<double>();
    const Eigen::Vector3d middle = 0.5 * (low + high);
    EXPECT_NEAR(Least(sides, {low.x(), middle.y(), middle.z()}, scale_m), 0, 0.03);
    EXPECT_NEAR(Least(sides, {high.x(), middle.y(), middle.z()}, scale_m), 0, 0.03);
    EXPECT_NEAR(Least(sides, {middle.x(), low.y(), middle.z()}, scale_m), 0, 0.03);
    EXPECT_NEAR(Least(sides, {middle.x(), high.y(), middle.z()}, scale_m), 0, 0.03);
    EXPECT_NEAR(Least(sides, {middle.x(), middle.y(), high.z()}, scale_m), 0, 0.03);
    EXPECT_GT(Least(sides, {middle.x(), middle.y(), low.z()}, scale_m), 0.2) << "no bottom";
  }
}

// The table carries a box of a third of its length.
TEST(MeasuredLimits, ASupportPlaneEndsAtItsLevelFace) {
  VoxelGrid grid = TableGrid();
  FillBox(grid, {-0.2, -0.15, 0.25}, {0.2, 0.15, 0.4});
  const FurnitureWorld world(grid, 1.6);
  const std::vector<ObjectView> views = world.Views(kAllRound);
  const refine::Limits of_table = MeasuredLimits(world.world_from_object(), views, true);
  const refine::Limits of_other = MeasuredLimits(world.world_from_object(), views, false);
  const double scale_m = world.world_from_object().scale;
  ASSERT_TRUE(of_table.top);
  EXPECT_EQ(of_table.sides.size(), 4U);
  EXPECT_NEAR(scale_m * of_table.top->SignedDistance({0, 0, 0.25}), 0, 0.03);
  EXPECT_FALSE(of_other.top);
  EXPECT_GT(Least(of_other.sides, {0, 0, 0.25}, scale_m), 0.1) << "up to the box's top";
}

TEST(MeasuredLimits, FewPointsSayNothing) {
  const FurnitureWorld world(TableGrid(), 1.6);
  EXPECT_TRUE(MeasuredLimits(world.world_from_object(), {}, true).sides.empty());
  std::vector<ObjectView> views = world.Views({0});
  views[0].mask_crop = Mask(views[0].mask_crop.width(), views[0].mask_crop.height());
  EXPECT_TRUE(MeasuredLimits(world.world_from_object(), views, true).sides.empty());
}

}  // namespace
}  // namespace deepslam::modelling
