#include "deepslam/alignment/degenerate_directions.h"

#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace deepslam::alignment {
namespace {

// A square of 2 m, of points on a plane through `centre`, as point-to-plane residuals see it.
void AddPlane(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, Matrix6d& hessian) {
  const Eigen::Vector3d a = normal.unitOrthogonal();
  const Eigen::Vector3d b = normal.cross(a);
  for (int i = -5; i <= 5; ++i) {
    for (int j = -5; j <= 5; ++j) {
      const Eigen::Vector3d p = centre + 0.2 * (i * a + j * b);
      Vector6d row;
      row << normal, p.cross(normal);
      hessian += row * row.transpose();
    }
  }
}

Matrix6d Wall() {
  Matrix6d hessian = Matrix6d::Zero();
  AddPlane({0, 0, 2}, {0, 0, -1}, hessian);
  return hessian;
}

Matrix6d WallAndFloor() {
  Matrix6d hessian = Wall();
  AddPlane({0, 1.2, 1.6}, {0, -1, 0}, hessian);
  return hessian;
}

Matrix6d Corner() {
  Matrix6d hessian = WallAndFloor();
  AddPlane({1.1, 0, 1.7}, {-1, 0, 0}, hessian);
  return hessian;
}

Vector6d Along(int axis) { return Vector6d::Unit(axis); }

TEST(DegenerateDirections, AreThoseThatKeepAWallOnItself) {
  const DegenerateDirections wall(Wall());
  ASSERT_FALSE(wall.empty());
  // Along the wall, and round its normal.
  for (const int axis : {0, 1, 5})
    EXPECT_LT((wall.Component(Along(axis)) - Along(axis)).norm(), 1e-6) << axis;
  // Towards it; and the turns that tilt it.
  EXPECT_LT(wall.Component(Along(2)).norm(), 1e-6);
  EXPECT_TRUE(DegenerateDirections(Corner()).empty());
}

TEST(DegenerateDirections, SplitAMotionOnceAndForAll) {
  const DegenerateDirections directions(WallAndFloor());
  ASSERT_FALSE(directions.empty());
  const Vector6d motion = (Vector6d() << 0.3, -0.2, 0.1, 0.05, 0.02, -0.04).finished();
  const Vector6d along = directions.Component(motion);
  EXPECT_GT(along.norm(), 0.1);
  EXPECT_LT((directions.Component(along) - along).norm(), 1e-9);
  EXPECT_LT(directions.Component(motion - along).norm(), 1e-9);
}

TEST(WeakDirections, AreAsManyAsTheSurfacesLeave) {
  EXPECT_EQ(WeakDirections(Wall()).size(), 3U);
  const std::vector<Vector6d> along = WeakDirections(WallAndFloor());
  ASSERT_EQ(along.size(), 1U);
  // Where wall meets floor: along x.
  EXPECT_NEAR(std::abs(along[0][0]) / along[0].norm(), 1, 0.01);
  EXPECT_TRUE(WeakDirections(Corner()).empty());
}

TEST(StructuralShare, TakesMostWhereDepthIsWeakest) {
  const Matrix6d hessian = WallAndFloor();
  const Matrix6d share = StructuralShare(hessian);
  const Matrix6d left = 0.5 * (share * hessian + (share * hessian).transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix6d> remaining(left), taken(hessian - left);
  EXPECT_GT(remaining.eigenvalues()[0], -1e-9);
  EXPECT_GT(taken.eigenvalues()[0], -1e-9);
  const auto share_along = [&](int axis) { return left(axis, axis) / hessian(axis, axis); };
  EXPECT_GT(share_along(2), 0.95);  // towards the wall
}

TEST(DirectionSpectrum, SaysNothingOfAHessianThatSaysNothing) {
  const Matrix6d nothing = Matrix6d::Zero();
  EXPECT_FALSE(SpectrumByArc(nothing).has_value());
  EXPECT_TRUE(DegenerateDirections(nothing).empty());
  EXPECT_EQ(DegenerateDirections(nothing).Component(Along(0)), Vector6d(Vector6d::Zero()));
  EXPECT_TRUE(WeakDirections(nothing).empty());
  EXPECT_EQ(StructuralShare(nothing), Matrix6d(Matrix6d::Identity()));
}

}  // namespace
}  // namespace deepslam::alignment
