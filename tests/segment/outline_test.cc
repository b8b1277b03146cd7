#include "deepslam/segment/outline.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>

namespace deepslam::segment {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

PlanarPoints Scattered(int count, double radius_m) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(-radius_m, radius_m);
  PlanarPoints points;
  while (static_cast<int>(points.x_m.size()) < count) {
    const Eigen::Vector2d p(anywhere(random), anywhere(random));
    if (p.norm() > radius_m) continue;
    points.x_m.push_back(3 + p.x());
    points.y_m.push_back(-1 + 0.4 * p.y());
  }
  return points;
}

double Cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
}

// Edge by edge, as the words say.
bool IsWithin(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& p, double margin_m) {
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d& a = hull[i];
    const Eigen::Vector2d& b = hull[(i + 1) % hull.size()];
    if (Cross(a, b, p) < -margin_m * (b - a).norm()) return false;
  }
  return true;
}

TEST(ConvexHull, IsConvexOfGivenPointsAndHoldsThemAll) {
  const PlanarPoints points = Scattered(5000, 0.8);
  const std::vector<Eigen::Vector2d> hull = ConvexHull(points);
  ASSERT_GE(hull.size(), 10U);
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const std::size_t n = hull.size();
    EXPECT_GT(Cross(hull[i], hull[(i + 1) % n], hull[(i + 2) % n]), 0.0);
    bool is_given = false;
    for (std::size_t k = 0; k < points.x_m.size(); ++k)
      is_given = is_given || hull[i] == Eigen::Vector2d(points.x_m[k], points.y_m[k]);
    EXPECT_TRUE(is_given);
  }
  for (std::size_t k = 0; k < points.x_m.size(); ++k)
    EXPECT_TRUE(IsWithin(hull, {points.x_m[k], points.y_m[k]}, 1e-12));
  EXPECT_GT(DoubleArea(hull), 0.95 * 2 * std::numbers::pi * 0.8 * 0.8 * 0.4);
}

TEST(ConvexHull, PointsAtOnePlaceAndOnALineHaveNoArea) {
  EXPECT_THAT(ConvexHull({}), IsEmpty());
  // All those that are looked at first lie at one place.
  PlanarPoints points{std::vector<double>(9, 2.0), std::vector<double>(9, 5.0)};
  EXPECT_LE(ConvexHull(points).size(), 2U);
  points.x_m[3] = 7;
  EXPECT_THAT(ConvexHull(points), SizeIs(2));
}

TEST(WithinHull, AgreesWithTheEdgesAtAnyMargin) {
  const std::vector<Eigen::Vector2d> hull = ConvexHull(Scattered(500, 0.8));
  for (const double margin_m : {-0.05, 0.0, 0.04}) {
    WithinHull within(hull, margin_m);
    int num_within = 0;
    const PlanarPoints asked = Scattered(20000, 1.2);
    for (std::size_t k = 0; k < asked.x_m.size(); ++k) {
      const bool expected = IsWithin(hull, {asked.x_m[k], asked.y_m[k]}, margin_m);
      EXPECT_EQ(within(asked.x_m[k], asked.y_m[k]), expected);
      num_within += expected ? 1 : 0;
    }
    EXPECT_GT(num_within, 5000);
    EXPECT_LT(num_within, 15000);
  }
}

TEST(WithinHull, NothingLiesWithinALine) {
  WithinHull within(std::vector<Eigen::Vector2d>{{0, 0}, {1, 0}}, 0.1);
  EXPECT_FALSE(within(0.5, 0.0));
}

}  // namespace
}  // namespace deepslam::segment
