#include "deepslam/detect/find_walls.h"

#include <cmath>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/random.h"

namespace deepslam::detect {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

// A patch of an upright plane between two places on the ground, as a camera at the origin sees it:
// as many points to its solid angle, with noise along the ray.
void AddPlane(const Eigen::Vector2d& from,
              const Eigen::Vector2d& to,
              double height_m,
              std::vector<UprightPoint>& points) {
  Random random(3, "wall", points.size());
  const double area_m2 = (to - from).norm() * height_m;
  const double distance_m = (0.5 * (from + to)).norm();
  const auto count = static_cast<int>(2000 * area_m2 / (distance_m * distance_m));
  for (int n = 0; n < count; ++n) {
    Eigen::Vector2d p = from + random.Uniform() * (to - from);
    const double depth_m = p.norm();
    p *= 1 + 0.002 * depth_m * random.Normal();
    points.push_back({p, random.Uniform() * height_m, depth_m, false});
  }
}

TEST(FindWallsTest, BothWallsOfACorner) {
  std::vector<UprightPoint> points;
  AddPlane({3, -2}, {3, 1}, 2, points);
  AddPlane({0, 1}, {3, 1}, 2, points);
  const std::vector<Wall> walls = FindWalls(points);
  ASSERT_THAT(walls, SizeIs(2));
  for (const Wall& wall : walls) {
    const bool is_far = std::abs(wall.normal.x()) > 0.5;
    const Eigen::Vector2d expected = is_far ? Eigen::Vector2d::UnitX() : Eigen::Vector2d::UnitY();
    EXPECT_GT(wall.normal.dot(expected), 0.9995) << "2 deg";
    EXPECT_NEAR(wall.distance_m, is_far ? 3 : 1, 0.02);
  }
}

TEST(FindWallsTest, AFrontWithAWallBehindIsNone) {
  std::vector<UprightPoint> points;
  AddPlane({2.4, -0.6}, {2.4, 0.6}, 1.9, points);  // a wardrobe
  AddPlane({3, -2}, {3, -0.7}, 2, points);
  AddPlane({3, 0.7}, {3, 2}, 2, points);
  const std::vector<Wall> walls = FindWalls(points);
  ASSERT_THAT(walls, SizeIs(1));
  EXPECT_NEAR(walls[0].distance_m, 3, 0.02);
}

TEST(FindWallsTest, LowAndShortPlanesAreNone) {
  std::vector<UprightPoint> points;
  AddPlane({2, -2}, {2, 2}, 1.1, points);  // a counter
  EXPECT_THAT(FindWalls(points), IsEmpty());
  points.clear();
  AddPlane({2, -0.3}, {2, 0.3}, 2, points);  // a pillar
  EXPECT_THAT(FindWalls(points), IsEmpty());
}

TEST(FindWallsTest, ALowOneThatRunsOutOfThePictureIsOne) {
  std::vector<UprightPoint> points;
  AddPlane({2, -2}, {2, 2}, 1.1, points);
  for (UprightPoint& point : points) point.at_top_edge = point.height_m > 1.05;
  EXPECT_THAT(FindWalls(points), SizeIs(1));
}

TEST(FindWallsTest, NothingAndOnePlace) {
  EXPECT_THAT(FindWalls({}), IsEmpty());
  const std::vector<UprightPoint> same(100, {{1, 1}, 1, 1, true});
  EXPECT_THAT(FindWalls(same), IsEmpty());
  const std::vector<UprightPoint> at_camera(100, {{0, 0}, 1, 0, true});
  EXPECT_THAT(FindWalls(at_camera), IsEmpty());
}

}  // namespace
}  // namespace deepslam::detect
