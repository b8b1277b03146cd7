#include "deepslam/instances/upright_box.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <Eigen/Geometry>

namespace deepslam::instances {
namespace {

using testing::DoubleNear;

// The rectangle is looked for in steps of 3 degrees, and leaves out one point in a hundred.
constexpr double kToleranceM = 0.04;

std::vector<Eigen::Vector3f> TurnedCuboid(double yaw_rad, const Eigen::Vector3d& size_m) {
  std::vector<Eigen::Vector3f> points;
  const Eigen::AngleAxisd turn(yaw_rad, Eigen::Vector3d::UnitZ());
  for (int x = 0; x <= 20; ++x) {
    for (int y = 0; y <= 20; ++y) {
      for (int z = 0; z <= 20; ++z) {
        const Eigen::Vector3d p =
            Eigen::Vector3d(x / 20.0 - 0.5, y / 20.0 - 0.5, z / 20.0).cwiseProduct(size_m);
        points.emplace_back((turn * p + Eigen::Vector3d(3, -2, 0.5)).cast<float>());
      }
    }
  }
  return points;
}

TEST(UprightBox, HoldsATurnedCuboid) {
  for (const double yaw_deg : {0.0, 12.0, 45.0, 81.0}) {
    const UprightBox box = BoxOf(TurnedCuboid(yaw_deg * std::numbers::pi / 180, {1.8, 0.6, 0.9}));
    EXPECT_THAT(box.long_side_m(), DoubleNear(1.8, kToleranceM)) << yaw_deg << " deg";
    EXPECT_THAT(box.short_side_m(), DoubleNear(0.6, kToleranceM)) << yaw_deg << " deg";
    EXPECT_THAT(box.bottom_m, DoubleNear(0.5, kToleranceM));
    EXPECT_THAT(box.top_m, DoubleNear(1.4, kToleranceM));
    EXPECT_LT((box.centre_m - Eigen::Vector2d(3, -2)).norm(), kToleranceM);
  }
}

TEST(UprightBox, IsNotSetByOneWrongPoint) {
  std::vector<Eigen::Vector3f> points = TurnedCuboid(0.3, {1, 0.5, 0.5});
  points.emplace_back(40, 0, 0);
  EXPECT_LT(BoxOf(points).long_side_m(), 1 + kToleranceM);
}

TEST(UprightBox, OfNothingOrOnePointHasNoSize) {
  EXPECT_EQ(BoxOf({}).long_side_m(), 0);
  const std::vector<Eigen::Vector3f> one = {Eigen::Vector3f(1, 2, 3)};
  EXPECT_EQ(BoxOf(one).long_side_m(), 0);
  EXPECT_EQ(BoxOf(one).top_m, 3);
}

}  // namespace
}  // namespace deepslam::instances
