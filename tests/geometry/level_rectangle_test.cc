#include "deepslam/geometry/level_rectangle.h"

#include <numbers>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"

namespace deepslam {
namespace {

LevelRectangle Draw(Random& random) {
  return {{random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5)},
          random.Uniform(-4, 4),
          random.Uniform(0.2, 2),
          random.Uniform(0.2, 2)};
}

TEST(LevelRectangle, SharedAreaIsThatOfSimpleOverlaps) {
  const LevelRectangle unit{{0, 0}, 0, 1, 1};
  EXPECT_NEAR(SharedArea(unit, unit), 1, 1e-12);
  EXPECT_NEAR(SharedArea(unit, {{0.75, 0.5}, 0, 1, 1}), 0.125, 1e-12);
  EXPECT_NEAR(SharedArea(unit, {{0, 0}, 0.3, 0.1, 0.1}), 0.01, 1e-12) << "one inside the other";
  EXPECT_NEAR(
      SharedArea(unit, {{0, 0}, std::numbers::pi / 4, 1, 1}), 2 * (std::numbers::sqrt2 - 1), 1e-12)
      << "an octagon";
  EXPECT_EQ(SharedArea(unit, {{2, 0}, 0.4, 1, 1}), 0);
  EXPECT_NEAR(SharedArea(unit, {{0, 0}, 0.4, 0, 1}), 0, 1e-12);
}

TEST(LevelRectangle, SharedAreaIsTheShareOfPointsInBoth) {
  Random random(1);
  for (int n = 0; n < 20; ++n) {
    const LevelRectangle a = Draw(random);
    const LevelRectangle b = Draw(random);
    constexpr double kStepM = 0.02;
    int num_both = 0;
    for (double x = -2.5; x < 2.5; x += kStepM) {
      for (double y = -2.5; y < 2.5; y += kStepM)
        num_both += a.Contains({x, y}) && b.Contains({x, y}) ? 1 : 0;
    }
    // Squares that a border goes through count in half: as many as the border is long.
    const double tolerance_m2 = kStepM * 2 * (a.length_m + a.width_m + b.length_m + b.width_m) / 2;
    EXPECT_NEAR(SharedArea(a, b), num_both * kStepM * kStepM, tolerance_m2);
    EXPECT_NEAR(SharedArea(a, b), SharedArea(b, a), 1e-9);
  }
}

TEST(HullAlong, HoldsBothAlongTheAxesOfTheFirst) {
  const LevelRectangle a{{1, 2}, 0.3, 0.8, 0.2};
  const LevelRectangle same = HullAlong(a, a);
  EXPECT_NEAR((same.centre_m - a.centre_m).norm(), 0, 1e-12);
  EXPECT_NEAR(same.area_m2(), a.area_m2(), 1e-12);
  const LevelRectangle b{{2, 2.5}, 0.3 + std::numbers::pi / 2, 0.2, 0.6};
  const LevelRectangle hull = HullAlong(a, b);
  EXPECT_EQ(hull.yaw_rad, a.yaw_rad);
  EXPECT_NEAR(SharedArea(hull, a), a.area_m2(), 1e-9);
  EXPECT_NEAR(SharedArea(hull, b), b.area_m2(), 1e-9);
  const Eigen::Vector2d apart = Eigen::Rotation2Dd(-0.3) * (b.centre_m - a.centre_m);
  EXPECT_NEAR(hull.length_m, 0.7 + apart.x(), 1e-9);
  EXPECT_NEAR(hull.width_m, 0.2 + apart.y(), 1e-9);
}

}  // namespace
}  // namespace deepslam
