#include "deepslam/propose/level_box.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/angles.h"
#include "deepslam/core/random.h"

namespace deepslam::propose {
namespace {

Eigen::Vector2d Turned(double yaw_rad, double x, double y) {
  return Eigen::Rotation2Dd(yaw_rad) * Eigen::Vector2d(x, y);
}

// Points of a box's faces, one per 2.5 cm with a noise of 5 mm: those at +x and +y alone.
std::vector<Eigen::Vector3f> TwoFaces(const Eigen::Vector3d& size_m, double yaw_rad) {
  Random random(5, "two faces", 0);
  std::vector<Eigen::Vector3f> points;
  const auto add = [&](double x, double y, double z) {
    const Eigen::Vector2d p = Turned(yaw_rad,
                                     0.5 * size_m.x() * x + 0.005 * random.Normal(),
                                     0.5 * size_m.y() * y + 0.005 * random.Normal());
    points.emplace_back(
        static_cast<float>(p.x() + 1), static_cast<float>(p.y() - 2), static_cast<float>(z));
  };
  for (double z = 0.0125; z < size_m.z(); z += 0.025) {
    for (double y = -1; y <= 1; y += 0.05 / size_m.y()) add(1, y, z);
    for (double x = -1; x <= 1; x += 0.05 / size_m.x()) add(x, 1, z);
  }
  return points;
}

// Between directions of sides, which repeat each quarter turn.
double ApartDeg(double a_rad, double b_rad) {
  return std::abs(kDegPerRad * std::remainder(a_rad - b_rad, 0.5 * std::numbers::pi));
}

class BoxYaw : public testing::TestWithParam<int> {};

TEST_P(BoxYaw, OfTwoFacesIsTheirs) {
  const double yaw_rad = GetParam() * kRadPerDeg;
  for (const Eigen::Vector3d& size_m : {Eigen::Vector3d(0.8, 0.9, 1.8),
                                        Eigen::Vector3d(0.6, 0.6, 0.9),
                                        Eigen::Vector3d(0.4, 1.2, 1)}) {
    const LevelBox box = MeasureBox(TwoFaces(size_m, yaw_rad));
    EXPECT_LE(ApartDeg(box.yaw_rad, yaw_rad), 2.5) << size_m.transpose();
    EXPECT_NEAR(box.size_m.head<2>().minCoeff(), size_m.head<2>().minCoeff(), 0.05);
    EXPECT_NEAR(box.size_m.head<2>().maxCoeff(), size_m.head<2>().maxCoeff(), 0.05);
    EXPECT_LT((box.center_m - Eigen::Vector2d(1, -2)).norm(), 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryTurn, BoxYaw, testing::Values(0, 20, 37, 45, 70, 88));

TEST(BoxYawOf, NoPointsIsABoxOfNothing) { EXPECT_EQ(MeasureBox({}).size_m.maxCoeff(), 0); }

// Leaves: points all through a ball's upper half, 30 cm in radius.
std::vector<Eigen::Vector3f> Bush(std::uint64_t seed) {
  Random random(seed, "bush", 0);
  std::vector<Eigen::Vector3f> points;
  while (points.size() < 1000) {
    const Eigen::Vector3d p(random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(0, 1));
    if (p.norm() > 1) continue;
    points.push_back((0.3 * p + Eigen::Vector3d(1, -2, 0)).cast<float>());
  }
  return points;
}

// In a room with a wall 1 m from the object that runs in this direction, and one farther away that
// runs in another.
class BoxInRoom : public BoxYaw {
 protected:
  LevelBox Measure(const std::vector<Eigen::Vector3f>& points) {
    const auto add_wall = [&](double yaw_rad, double away_m) {
      LayoutWall wall;
      const Eigen::Vector2d middle = Eigen::Vector2d(1, -2) + Turned(yaw_rad, 0, away_m);
      wall.from_m = middle + Turned(yaw_rad, 2, 0);
      wall.to_m = middle + Turned(yaw_rad, -2, 0);
      wall.top_m = 2.5;
      layout_.walls.push_back(wall);
    };
    add_wall(wall_yaw_rad_ + 0.5, -3);
    add_wall(wall_yaw_rad_, 1);
    ObjectObservations object;
    object.layout = &layout_;
    LevelCloud cloud;
    cloud.points = points;
    return MeasureBox(object, cloud);
  }

  double wall_yaw_rad_ = GetParam() * kRadPerDeg;
  Layout layout_;
};

TEST_P(BoxInRoom, OfWhatHasNoSidesStandsAlongTheNearestWall) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    EXPECT_LE(ApartDeg(Measure(Bush(seed)).yaw_rad, wall_yaw_rad_), 5);
  }
}

TEST_P(BoxInRoom, OfTwoFacesStandsAsTheyDo) {
  for (const double off_deg : {0, 3, 12, 30, 45}) {
    const double yaw_rad = wall_yaw_rad_ + off_deg * kRadPerDeg;
    const LevelBox box = Measure(TwoFaces({0.6, 0.5, 0.9}, yaw_rad));
    EXPECT_LE(ApartDeg(box.yaw_rad, yaw_rad), 2.5) << off_deg;
  }
}

INSTANTIATE_TEST_SUITE_P(EveryTurn, BoxInRoom, testing::Values(0, 20, 37, 45, 70, 88));

}  // namespace
}  // namespace deepslam::propose
