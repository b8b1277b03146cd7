#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/geometry/box.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/facing.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/geometry/symmetric_matrix6.h"
#include "deepslam/scene/ground.h"
#include "support/pose_matchers.h"

namespace deepslam {
namespace {

using testing_support::PoseNear;

Pose3 RandomPose(Random& random) {
  Vector6d v;
  for (int i = 0; i < 3; ++i) v[i] = random.Uniform(-2, 2);
  for (int i = 3; i < 6; ++i) v[i] = random.Uniform(-1.8, 1.8);
  return V2t(v);
}

TEST(Pose3, InverseAndCompositionCancel) {
  Random random(1);
  for (int n = 0; n < 100; ++n) {
    const Pose3 b_from_a = RandomPose(random);
    const Pose3 c_from_b = RandomPose(random);
    const Eigen::Vector3d x_a(random.Normal(), random.Normal(), random.Normal());
    EXPECT_LT(((b_from_a.Inverse() * (b_from_a * x_a)) - x_a).norm(), 1e-12);
    EXPECT_LT((((c_from_b * b_from_a) * x_a) - (c_from_b * (b_from_a * x_a))).norm(), 1e-12);
    EXPECT_THAT(Pose3::FromMatrix(b_from_a.Matrix()), PoseNear(b_from_a, 1e-12, 1e-6));
  }
}

TEST(Pose3, T2vAndV2tAreInverse) {
  Random random(2);
  for (int n = 0; n < 100; ++n) {
    const Pose3 pose = RandomPose(random);
    EXPECT_THAT(V2t(T2v(pose)), PoseNear(pose, 1e-12, 1e-6));
  }
  // Angles at both ends of the range, and the two quaternions of one rotation.
  for (const double angle : {0.0, 1e-13, 1e-7, 1.0, std::numbers::pi - 1e-9}) {
    const Eigen::Vector3d v = angle * Eigen::Vector3d(1, 2, -2) / 3.0;
    const Eigen::Quaterniond q = RotationFromVector(v);
    EXPECT_LT((RotationVector(q) - v).norm(), 1e-9) << angle;
    EXPECT_LT((RotationVector(Eigen::Quaterniond(-q.coeffs())) - v).norm(), 1e-9) << angle;
  }
}

TEST(Pose3, AdjointCarriesPerturbations) {
  Random random(3);
  const Pose3 b_from_a = RandomPose(random);
  Vector6d d_a;
  for (int i = 0; i < 6; ++i) d_a[i] = 1e-5 * random.Normal();
  const Pose3 left = V2t(Adjoint(b_from_a) * d_a) * b_from_a;
  const Pose3 right = b_from_a * V2t(d_a);
  EXPECT_THAT(left, PoseNear(right, 1e-9, 1e-7));
}

TEST(Similarity3, InverseAndCompositionCancel) {
  Random random(4);
  for (int n = 0; n < 50; ++n) {
    const Similarity3 b_from_a = Similarity3::From(RandomPose(random), random.Uniform(0.2, 3));
    const Similarity3 c_from_b = Similarity3::From(RandomPose(random), random.Uniform(0.2, 3));
    const Eigen::Vector3d x_a(random.Normal(), random.Normal(), random.Normal());
    EXPECT_LT(((b_from_a.Inverse() * (b_from_a * x_a)) - x_a).norm(), 1e-11);
    EXPECT_LT((((c_from_b * b_from_a) * x_a) - (c_from_b * (b_from_a * x_a))).norm(), 1e-11);
  }
}

TEST(PlaneTest, TransformsWithItsPoints) {
  Random random(5);
  const Plane plane_a{Eigen::Vector3d(1, 2, 3).normalized(), 0.7};
  for (int n = 0; n < 50; ++n) {
    const Pose3 b_from_a = RandomPose(random);
    const Eigen::Vector3d x_a(random.Normal(), random.Normal(), random.Normal());
    EXPECT_NEAR(Transformed(b_from_a, plane_a).SignedDistance(b_from_a * x_a),
                plane_a.SignedDistance(x_a),
                1e-12);
  }
}

TEST(GroundTangentBasisTest, IsOrthonormalForAwkwardNormals) {
  for (const Eigen::Vector3d& raw : {Eigen::Vector3d(0, 0, 1),
                                     Eigen::Vector3d(0, -1, 0),
                                     Eigen::Vector3d(1, 0, 0),
                                     Eigen::Vector3d(1, 1, 1),
                                     Eigen::Vector3d(1e-9, -1, 1e-9)}) {
    const Eigen::Vector3d n = raw.normalized();
    const auto basis = GroundTangentBasis(n);
    EXPECT_LT((basis.transpose() * basis - Eigen::Matrix2d::Identity()).norm(), 1e-12);
    EXPECT_LT((basis.transpose() * n).norm(), 1e-12);
  }
}

TEST(PinholeCameraTest, ReducedCameraSeesTheSamePoint) {
  const PinholeCamera camera{640, 480, 525, 520, 319.5, 239.5};
  const Eigen::Vector3d p(0.3, -0.2, 1.7);
  const Eigen::Vector2d full = *camera.Project(p);
  const Eigen::Vector2d half = *camera.Reduced(2).Project(p);
  // Pixel centres of the reduced image are the middles of 2 x 2 blocks.
  EXPECT_LT(((half.array() + 0.5) * 2.0 - 0.5 - full.array()).matrix().norm(), 1e-12);
  EXPECT_LT((camera.Unproject(full.x(), full.y(), p.z()) - p).norm(), 1e-12);
  EXPECT_FALSE(camera.Project(Eigen::Vector3d(0, 0, -1)).has_value());
}

TEST(Box2Test, IntersectionOverUnionOfKnownBoxes) {
  const Box2 a{0, 0, 2, 2};
  const Box2 b{1, 0, 3, 2};
  EXPECT_DOUBLE_EQ(IntersectionOverUnion(a, b), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(IntersectionOverUnion(a, a), 1.0);
  EXPECT_DOUBLE_EQ(IntersectionOverUnion(a, Box2{5, 5, 6, 6}), 0.0);
  EXPECT_DOUBLE_EQ(IntersectionOverUnion(Box2{}, Box2{}), 0.0);
}

TEST(BackShown, IsTheShareOfTheWayRoundFromTheFront) {
  // An object at (1, 2, 0) that faces world y.
  const Eigen::Quaterniond world_from_object(
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d center(1, 2, 0);
  const auto shown = [&](std::vector<Eigen::Vector3d> cameras) {
    return BackShown(world_from_object, center, cameras);
  };
  EXPECT_NEAR(shown({{1, 5, 1.4}}), 0.0, 1e-12);
  EXPECT_NEAR(shown({{1, -1, 1.4}}), 1.0, 1e-12);
  EXPECT_NEAR(shown({{4, 2, 0.3}}), 0.5, 1e-12);
  EXPECT_NEAR(shown({{1, 5, 0}, {1, -1, 0}}), 0.5, 1e-12);
  EXPECT_EQ(shown({}), 0.5);
  EXPECT_NEAR(shown({{1, 2, 3}}), 0.5, 1e-12);  // straight above
}

TEST(SymmetricMatrix6, IsTheMatrixItWasMadeOf) {
  Matrix6d root;
  for (int k = 0; k < 36; ++k) root.data()[k] = std::sin(1.0 + k);
  const Matrix6d lower = (root * root.transpose()).triangularView<Eigen::Lower>();
  const Matrix6d symmetric = lower.selfadjointView<Eigen::Lower>();
  const SymmetricMatrix6d packed = symmetric;
  EXPECT_EQ(packed.Full(), symmetric);
  EXPECT_EQ(packed, SymmetricMatrix6d(packed.Full()));
  EXPECT_EQ(SymmetricMatrix6d().Full(), Matrix6d::Zero());
  EXPECT_LT(sizeof(packed), sizeof(symmetric) * 2 / 3);
}

}  // namespace
}  // namespace deepslam
