#include "deepslam/convex/convex_hull.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <gtest/gtest.h>

#include "convex/convex_samples.h"
#include "deepslam/convex/mass_properties.h"
#include "deepslam/core/random.h"
#include "deepslam/shape/mesh_check.h"

namespace deepslam::convex {
namespace {

std::vector<Eigen::Vector3f> Ball(int count, float flat = 1) {
  std::vector<Eigen::Vector3f> points;
  for (int n = 0; n < count; ++n) {
    const double z = 1 - (2.0 * n + 1) / count;
    const double radius = std::sqrt(1 - z * z);
    points.emplace_back(static_cast<float>(radius * std::cos(2.4 * n)),
                        static_cast<float>(radius * std::sin(2.4 * n)),
                        flat * static_cast<float>(z));
  }
  return points;
}

TEST(ConvexHull, IsClosedAndHoldsAllPoints) {
  std::vector<Eigen::Vector3f> points = Ball(200);
  points.emplace_back(0, 0, 0);
  const TriangleMesh hull = ConvexHull(points);
  EXPECT_TRUE(shape::CheckMesh(hull).ok()) << shape::CheckMesh(hull).fault;
  EXPECT_NEAR(VolumeOf(hull), 4.0 / 3 * 3.14159, 0.2);
  EXPECT_NEAR(VolumeOf(testing_support::BoxMesh({0, 0, 0}, {1, 2, 3})), 6, 1e-6);
}

TEST(ConvexHull, OfWhatIsFlatIsEmpty) {
  EXPECT_TRUE(ConvexHull({}).empty());
  const std::vector<Eigen::Vector3f> flat = {
      {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {0.5F, 0.2F, 1}};
  EXPECT_TRUE(ConvexHull(flat).empty());
  const std::vector<Eigen::Vector3f> same(10, Eigen::Vector3f(1, 2, 3));
  EXPECT_TRUE(ConvexHull(same).empty());
}

TEST(ConvexHull, IsTheSameInWhateverOrderPointsCome) {
  // Many points in each plane and along each edge, which hulls may be cut at in many ways.
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; j <= 4; ++j) {
      for (int k = 0; k <= 4; ++k)
        points.push_back(
            Eigen::Vector3i(i, j, k).cast<float>().cwiseProduct(Eigen::Vector3f(0.3F, 0.7F, 0.2F)));
    }
  }
  const TriangleMesh box = ConvexHull(points);
  EXPECT_EQ(box.vertices.size(), 8U);
  EXPECT_EQ(box.faces.size(), 12U);
  EXPECT_TRUE(shape::CheckMesh(box).ok()) << shape::CheckMesh(box).fault;
  EXPECT_NEAR(VolumeOf(box), 1.2 * 2.8 * 0.8, 1e-5);
  const std::vector<Eigen::Vector3f> prism = {{0, 0, 0},
                                              {2, 0, 0},
                                              {3, 1, 0},
                                              {2, 2, 0},
                                              {0, 2, 0},
                                              {-1, 1, 0},
                                              {0, 0, 1},
                                              {2, 0, 1},
                                              {3, 1, 1},
                                              {2, 2, 1},
                                              {0, 2, 1},
                                              {-1, 1, 1}};
  for (std::vector<Eigen::Vector3f> some : {points, prism, Ball(60)}) {
    const TriangleMesh first = ConvexHull(some);
    for (int n = 0; n < 20; ++n) {
      std::next_permutation(some.begin(), some.end(), [](const auto& a, const auto& b) {
        return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
      });
      std::rotate(some.begin(), some.begin() + 7, some.end());
      const TriangleMesh again = ConvexHull(some);
      EXPECT_EQ(again.vertices, first.vertices);
      EXPECT_EQ(again.faces, first.faces);
    }
  }
}

TEST(BoundedHull, KeepsTheVolumeWithFewVertices) {
  for (const float flat : {1.0F, 0.02F}) {
    const std::vector<Eigen::Vector3f> points = Ball(3000, flat);
    const TriangleMesh hull = BoundedHull(points, 64);
    EXPECT_LE(hull.vertices.size(), 64U);
    EXPECT_TRUE(shape::CheckMesh(hull).ok());
    EXPECT_GT(VolumeOf(hull), 0.85 * VolumeOf(ConvexHull(points))) << flat;
  }
}

TEST(ClipConvex, CutsAtThePlane) {
  const TriangleMesh box = testing_support::BoxMesh({0, 0, 0}, {1, 1, 1});
  EXPECT_NEAR(VolumeOf(ClipConvex(box, {1, 0, 0}, 0.25)), 0.25, 1e-6);
  EXPECT_NEAR(VolumeOf(ClipConvex(box, {-1, 0, 0}, -0.25)), 0.75, 1e-6);
  const Eigen::Vector3d diagonal = Eigen::Vector3d(1, 1, 1).normalized();
  EXPECT_NEAR(VolumeOf(ClipConvex(box, diagonal, 1 / std::sqrt(3.0))), 1.0 / 6, 1e-6);
  EXPECT_EQ(ClipConvex(box, {1, 0, 0}, 2).vertices.size(), box.vertices.size());
  EXPECT_TRUE(ClipConvex(box, {1, 0, 0}, -1).empty());
}

}  // namespace
}  // namespace deepslam::convex
