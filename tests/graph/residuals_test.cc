#include "deepslam/graph/residuals.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/graph/information.h"
#include "deepslam/scene/ground.h"

namespace deepslam::graph {
namespace {

Pose3 RandomPose(Random& random, double spread_m, double spread_rad) {
  Vector6d v;
  for (int k = 0; k < 3; ++k) v[k] = random.Uniform(-spread_m, spread_m);
  for (int k = 3; k < 6; ++k) v[k] = random.Uniform(-spread_rad, spread_rad);
  return V2t(v);
}

using Block = Eigen::Matrix<double, 7, 1>;
Block BlockOf(const Pose3& pose) {
  Block block;
  block << pose.rotation.coeffs(), pose.translation_m;
  return block;
}

Eigen::Vector4d BlockOf(const Plane& plane) {
  return {plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.d_m};
}

template <int N>
Eigen::Matrix<double, N, N> RandomInformation(Random& random) {
  Eigen::Matrix<double, N, N> root;
  for (int k = 0; k < N * N; ++k) root(k) = random.Normal();
  return root * root.transpose() + 0.1 * Eigen::Matrix<double, N, N>::Identity();
}

// Largest difference between Ceres' automatic derivatives and central differences.
template <typename Functor, int N, int A, int B>
double JacobianError(const Functor& functor,
                     Eigen::Matrix<double, A, 1> a,
                     Eigen::Matrix<double, B, 1> b) {
  const ceres::AutoDiffCostFunction<Functor, N, A, B> cost(new Functor(functor));
  Eigen::Matrix<double, N, A, (A == 1 ? Eigen::ColMajor : Eigen::RowMajor)> by_a;
  Eigen::Matrix<double, N, B, (B == 1 ? Eigen::ColMajor : Eigen::RowMajor)> by_b;
  Eigen::Matrix<double, N, 1> residual;
  const double* const blocks[] = {a.data(), b.data()};
  double* jacobians[] = {by_a.data(), by_b.data()};
  cost.Evaluate(blocks, residual.data(), jacobians);
  constexpr double kStep = 1e-6;
  double worst = 0;
  const auto compare = [&](double& variable, const auto& column) {
    const double kept = variable;
    Eigen::Matrix<double, N, 1> up, down;
    variable = kept + kStep;
    functor(a.data(), b.data(), up.data());
    variable = kept - kStep;
    functor(a.data(), b.data(), down.data());
    variable = kept;
    worst = std::max(worst, ((up - down) / (2 * kStep) - column).cwiseAbs().maxCoeff());
  };
  for (int k = 0; k < A; ++k) compare(a[k], by_a.col(k));
  for (int k = 0; k < B; ++k) compare(b[k], by_b.col(k));
  return worst;
}

TEST(Residuals, JacobiansAgreeWithNumericOnes) {
  Random random(7);
  for (int n = 0; n < 20; ++n) {
    const Pose3 a = RandomPose(random, 5, 1.5);
    const Pose3 b = RandomPose(random, 5, 1.5);
    const Plane plane{Eigen::Vector3d(0.1, -0.9, 0.2).normalized(), 1.3};
    const PoseResidual pose{RandomPose(random, 1, 1),
                            SqrtInformation<6>(RandomInformation<6>(random))};
    EXPECT_LT((JacobianError<PoseResidual, 6, 7, 7>(pose, BlockOf(a), BlockOf(b))), 1e-6);
    const GroundResidual ground{
        GroundTangentBasis(plane.normal), 1.2, SqrtInformation<3>(RandomInformation<3>(random))};
    EXPECT_LT((JacobianError<GroundResidual, 3, 7, 4>(ground, BlockOf(a), BlockOf(plane))), 1e-6);
    EXPECT_LT((JacobianError<UprightResidual, 3, 7, 4>({}, BlockOf(a), BlockOf(plane))), 1e-6);
  }
}

// A frame 100 m away under a camera that leans: derivatives by the rotation grow with the distance,
// so that the difference is compared by their size.
TEST(Residuals, JacobiansAgreeWithNumericOnesFarFromTheOrigin) {
  Random random(17);
  for (int n = 0; n < 20; ++n) {
    Pose3 a = RandomPose(random, 5, 1.5);
    Pose3 b = RandomPose(random, 5, 1.5);
    a.translation_m += Eigen::Vector3d(80, -60, 0);
    b.translation_m += Eigen::Vector3d(80, -60, 0);
    const Plane plane{Eigen::Vector3d(0.1, 0.05, 1).normalized(), -4.0};
    const Plane seen = Transformed(a.Inverse(), plane);
    constexpr double kRelative = 1e-6;
    constexpr double kArm_m = 100;
    EXPECT_LT(
        (JacobianError<PoseResidual, 6, 7, 7>(
            {(a.Inverse() * b).Inverse() * RandomPose(random, 0.1, 0.1), Matrix6d::Identity()},
            BlockOf(a),
            BlockOf(b))),
        kRelative * kArm_m);
    EXPECT_LT((JacobianError<GroundResidual, 3, 7, 4>(
                  {GroundTangentBasis(seen.normal), seen.d_m + 0.1, Eigen::Matrix3d::Identity()},
                  BlockOf(a),
                  BlockOf(plane))),
              kRelative * kArm_m);
    EXPECT_LT((JacobianError<UprightResidual, 3, 7, 4>({}, BlockOf(a), BlockOf(plane))), kRelative);
  }
}

TEST(Residuals, AllAreZeroAtTheTruth) {
  Random random(18);
  const Plane plane{Eigen::Vector3d(0.1, 0.05, 1).normalized(), 0.7};
  for (int n = 0; n < 20; ++n) {
    Pose3 a = RandomPose(random, 100, 1.5);
    const Pose3 b = RandomPose(random, 100, 1.5);
    Vector6d pose;
    PoseResidual{(a.Inverse() * b).Inverse(), Matrix6d::Identity()}(
        BlockOf(a).data(), BlockOf(b).data(), pose.data());
    EXPECT_LT(pose.norm(), 1e-12);
    const Plane seen = Transformed(a.Inverse(), plane);
    Eigen::Vector3d ground;
    GroundResidual{GroundTangentBasis(seen.normal), seen.d_m, Eigen::Matrix3d::Identity()}(
        BlockOf(a).data(), BlockOf(plane).data(), ground.data());
    EXPECT_LT(ground.norm(), 1e-12);
    // An object upright on the plane, at any yaw.
    const Pose3 standing{ShortestRotation(Eigen::Vector3d::UnitZ(), plane.normal) *
                             Eigen::AngleAxisd(random.Uniform(-3, 3), Eigen::Vector3d::UnitZ()),
                         a.translation_m};
    Eigen::Vector3d upright;
    UprightResidual()(BlockOf(standing).data(), BlockOf(plane).data(), upright.data());
    EXPECT_LT(upright.norm(), 1e-12);
  }
}

TEST(Residuals, PoseJacobianIsFiniteAtZeroResidual) {
  Random random(8);
  const Pose3 a = RandomPose(random, 5, 1.5);
  const Pose3 b = RandomPose(random, 5, 1.5);
  const PoseResidual residual{(a.Inverse() * b).Inverse(), Matrix6d::Identity()};
  // Central differences of a rotation vector across zero are good to the step's size.
  EXPECT_LT((JacobianError<PoseResidual, 6, 7, 7>(residual, BlockOf(a), BlockOf(b))), 1e-5);
}

TEST(Residuals, PoseResidualIsT2vOfThePaper) {
  Random random(9);
  for (int n = 0; n < 50; ++n) {
    const Pose3 a = RandomPose(random, 5, 1.5);
    const Pose3 b = RandomPose(random, 5, 1.5);
    const Pose3 z = RandomPose(random, 1, 1.5);
    Vector6d residual;
    PoseResidual{z.Inverse(), Matrix6d::Identity()}(
        BlockOf(a).data(), BlockOf(b).data(), residual.data());
    EXPECT_LT((residual - T2v(z.Inverse() * a.Inverse() * b)).norm(), 1e-12);
  }
}

// The paper's form, literally: p - [R n_i; d_i - (R n_i)^T t] with the information carried by the
// pseudo-inverse of the Jacobian that moves the world's 4-vector with the measurement.
double PaperGroundEnergy(const Pose3& world_from_camera,
                         const Plane& world,
                         const Plane& camera,
                         const Eigen::Matrix3d& information) {
  const Plane seen = Transformed(world_from_camera, camera);
  const Eigen::Vector4d r = BlockOf(world) - BlockOf(seen);
  const Eigen::Matrix<double, 3, 2> tangents =
      world_from_camera.rotation.toRotationMatrix() * GroundTangentBasis(camera.normal);
  Eigen::Matrix<double, 4, 3> jacobian;
  jacobian << tangents, Eigen::Vector3d::Zero(),
      -world_from_camera.translation_m.transpose() * tangents, 1.0;
  const Eigen::Vector3d reduced =
      (jacobian.transpose() * jacobian).inverse() * jacobian.transpose() * r;
  return reduced.dot(information * reduced);
}

TEST(Residuals, GroundEdgeIsThePapersAlsoFarFromTheOrigin) {
  Random random(10);
  for (const double distance_m : {0.0, 3.0, 100.0}) {
    const Eigen::Quaterniond tilted(
        Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, 0.4, -0.3).normalized()));
    const Pose3 world_from_camera{tilted, Eigen::Vector3d(distance_m, -0.5 * distance_m, 1.4)};
    const Plane world{Eigen::Vector3d(0.02, -0.01, 1).normalized(), 0.3};
    Plane camera = Transformed(world_from_camera.Inverse(), world);
    const auto basis = GroundTangentBasis(camera.normal);
    const Eigen::Matrix3d information = RandomInformation<3>(random);
    const auto energy = [&](const Plane& measured) {
      const GroundResidual functor{
          GroundTangentBasis(measured.normal), measured.d_m, SqrtInformation<3>(information)};
      Eigen::Vector3d r;
      functor(BlockOf(world_from_camera).data(), BlockOf(world).data(), r.data());
      return r.squaredNorm();
    };
    EXPECT_LT(energy(camera), 1e-20) << "zero at truth, " << distance_m << " m";
    // A measurement off by a known error costs that error under its own information, wherever the
    // camera stands.
    const Eigen::Vector3d error(1e-5, -2e-5, 3e-5);
    Plane off = camera;
    off.normal = (camera.normal + basis * error.head<2>()).normalized();
    off.d_m += error[2];
    const double expected = error.dot(information * error);
    EXPECT_NEAR(energy(off) / expected, 1.0, 0.01) << distance_m << " m";
    EXPECT_NEAR(
        energy(off) / PaperGroundEnergy(world_from_camera, world, off, information), 1.0, 0.01)
        << distance_m << " m";
  }
}

TEST(BalancedInformation, AddsCovariancesAndKeepsTheNullSpace) {
  Vector6d diagonal, floor;
  diagonal << 1e8, 1e4, 1, 0, 1e6, 1e2;
  floor << 0.01, 0.01, 0.01, 0.1, 0.1, 0.1;
  const Matrix6d balanced = BalancedInformation<6>(diagonal.asDiagonal(), 10, floor);
  for (int k = 0; k < 6; ++k) {
    const double expected =
        diagonal[k] > 0 ? 1.0 / (10.0 / diagonal[k] + floor[k] * floor[k]) : 0.0;
    EXPECT_NEAR(balanced(k, k), expected, 1e-6 * (1 + expected));
  }
}

TEST(BalancedInformation, CoupledDirectionsStayCoupled) {
  Random random(11);
  const Matrix6d information = RandomInformation<6>(random);
  const Vector6d floor = Vector6d::Constant(0.2);
  const Matrix6d covariance = 3.0 * information.inverse() + 0.04 * Matrix6d::Identity();
  EXPECT_LT(
      (BalancedInformation<6>(information, 3.0, floor) * covariance - Matrix6d::Identity()).norm(),
      1e-9);
}

TEST(BalancedInformation, RefusesWhatIsNotFinite) {
  Matrix6d information = Matrix6d::Identity();
  information(2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(BalancedInformation<6>(information, 1, Vector6d::Ones()), Matrix6d::Zero());
}

TEST(SqrtInformation, SquaresToTheInformation) {
  Random random(12);
  const Matrix6d information = RandomInformation<6>(random);
  const Matrix6d root = SqrtInformation<6>(information);
  EXPECT_LT((root.transpose() * root - information).norm(), 1e-9);
}

TEST(WithoutYaw, EnergyDoesNotDependOnTheFreeYaw) {
  Random random(13);
  const Pose3 measured = RandomPose(random, 2, 1);
  const Matrix6d information = RandomInformation<6>(random);
  const Vector6d small = 1e-4 * Vector6d::LinSpaced(1, 2);
  double first = 0;
  for (int k = 0; k < 8; ++k) {
    const Pose3 yaw{Eigen::Quaterniond(Eigen::AngleAxisd(0.8 * k, Eigen::Vector3d::UnitZ())),
                    Eigen::Vector3d::Zero()};
    const Pose3 expected = measured * V2t(small) * yaw;
    const YawFreeMeasurement free = WithoutYaw(measured, information, expected);
    const Vector6d error = T2v(free.a_from_b.Inverse() * expected);
    const double energy = error.dot(free.information * error);
    if (k == 0) first = energy;
    EXPECT_NEAR(energy / first, 1.0, 1e-2);
    EXPECT_NEAR(error[5], 0.0, 1e-7);
  }
  EXPECT_GT(first, 0);
}

}  // namespace
}  // namespace deepslam::graph
