#include "deepslam/mesh/ground_polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace deepslam::mesh {
namespace {

// Points every 4 cm over [0, w] x [0, h] where `keep` holds.
template <typename Keep>
std::vector<Eigen::Vector2d> Floor(double w, double h, Keep keep) {
  std::vector<Eigen::Vector2d> points;
  for (double x = 0; x <= w + 1e-9; x += 0.04) {
    for (double y = 0; y <= h + 1e-9; y += 0.04) {
      if (keep(x, y)) points.emplace_back(x, y);
    }
  }
  return points;
}

double Area(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3f u = mesh.vertices[face[1]] - mesh.vertices[face[0]];
    const Eigen::Vector3f v = mesh.vertices[face[2]] - mesh.vertices[face[0]];
    area += 0.5 * static_cast<double>(u.x() * v.y() - u.y() * v.x());  // > 0: faces up
  }
  return area;
}

TEST(GroundPolygon, OutlinesAnLShapedFloorAndBridgesWhatStandsOnIt) {
  const auto floor = Floor(4, 3, [](double x, double y) {
    const bool notch = x > 2.5 && y > 1.5;
    const bool table = std::abs(x - 1) < 0.15 && std::abs(y - 1) < 0.15;
    return !notch && !table;
  });
  const Result<TriangleMesh> mesh = GroundPolygon(floor);
  ASSERT_TRUE(mesh.ok());
  // 12 - 1.5 * 1.5 square metres; the notch's corner is rounded by alpha, the outline simplified by
  // 3 cm.
  EXPECT_NEAR(Area(*mesh), 9.75, 0.35);
  EXPECT_LT(mesh->faces.size(), 60U);
  for (const Eigen::Vector3f& p : mesh->vertices) EXPECT_EQ(p.z(), 0.0F);
}

TEST(GroundPolygon, OutlineAloneGivesTheSameFloorBack) {
  const auto floor = Floor(4, 3, [](double x, double y) { return !(x > 2.5 && y > 1.5); });
  const Result<TriangleMesh> mesh = GroundPolygon(floor);
  ASSERT_TRUE(mesh.ok());
  const std::vector<Eigen::Vector2d> outline = OutlineOf(*mesh);
  EXPECT_EQ(outline.size(), mesh->vertices.size());
  const Result<TriangleMesh> again = TriangulateOutline(outline);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->faces.size(), mesh->faces.size());
  EXPECT_NEAR(Area(*again), Area(*mesh), 1e-5);
  EXPECT_EQ(OutlineOf(*again), outline);
}

TEST(GroundPolygon, RefusesOutlinesThatAreNone) {
  using Outline = std::vector<Eigen::Vector2d>;
  EXPECT_FALSE(TriangulateOutline(Outline{}).ok());
  EXPECT_FALSE(TriangulateOutline(Outline{{0, 0}, {1, 0}}).ok());
  EXPECT_FALSE(TriangulateOutline(Outline{{0, 0}, {1, 1}, {1, 0}, {0, 1}}).ok());
  EXPECT_FALSE(TriangulateOutline(Outline{{0, 0}, {1, std::nan("")}, {0, 1}}).ok());
  EXPECT_TRUE(OutlineOf({}).empty());
}

TEST(GroundPolygon, DoesNotDependOnTheOrderOfPoints) {
  auto floor = Floor(2, 2, [](double x, double y) { return x + y < 3; });
  const Result<TriangleMesh> a = GroundPolygon(floor);
  std::reverse(floor.begin(), floor.end());
  const Result<TriangleMesh> b = GroundPolygon(floor);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->vertices, b->vertices);
  EXPECT_EQ(a->faces, b->faces);
}

TEST(GroundPolygon, TakesTheLargestPieceAndLeavesOutNonsense) {
  auto floor = Floor(4, 2, [](double x, double) { return x < 2 || x > 3; });
  floor.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0.0);
  floor.emplace_back(std::numeric_limits<double>::infinity(), 0.0);
  floor.emplace_back(1e30, 1e30);
  const Result<TriangleMesh> mesh = GroundPolygon(floor);
  ASSERT_TRUE(mesh.ok());
  EXPECT_NEAR(Area(*mesh), 4.0, 0.3);
}

TEST(GroundPolygon, RefusesPointsWithoutArea) {
  std::vector<Eigen::Vector2d> line;
  for (int n = 0; n < 50; ++n) line.emplace_back(0.05 * n, 0.0);
  EXPECT_FALSE(GroundPolygon(line).ok());
  EXPECT_FALSE(GroundPolygon({}).ok());
}

}  // namespace
}  // namespace deepslam::mesh
