// Information matrices made honest and comparable.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "deepslam/geometry/pose.h"

namespace deepslam::graph {

// (scale * Omega^-1 + diag(floor)^2)^-1, with the null space of Omega kept (no information stays
// none); negative eigenvalues count as 0. `floor` per component, > 0. Nothing finite in, nothing
// out: a matrix that is not finite gives 0.
template <int N>
[[nodiscard]] Eigen::Matrix<double, N, N> BalancedInformation(
    const Eigen::Matrix<double, N, N>& information,
    double scale,
    const Eigen::Matrix<double, N, 1>& floor) {
  using Matrix = Eigen::Matrix<double, N, N>;
  if (!information.allFinite()) return Matrix::Zero();
  // In units of the floor: eigenvalue l becomes l / (scale + l) < 1.
  const Matrix symmetric = 0.5 * (information + information.transpose());
  const Matrix scaled = floor.asDiagonal() * symmetric * floor.asDiagonal();
  if (!scaled.allFinite()) return Matrix::Zero();
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(scaled);
  const Eigen::Matrix<double, N, 1> values =
      solver.eigenvalues().unaryExpr([scale](double l) { return l > 0 ? l / (scale + l) : 0.0; });
  const Matrix bounded =
      solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
  const Eigen::Matrix<double, N, 1> inverse = floor.cwiseInverse();
  const Matrix result = inverse.asDiagonal() * bounded * inverse.asDiagonal();
  return 0.5 * (result + result.transpose());
}

// L with L^T L = information (symmetric, positive semidefinite).
template <int N>
[[nodiscard]] Eigen::Matrix<double, N, N> SqrtInformation(
    const Eigen::Matrix<double, N, N>& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>> solver(information);
  const Eigen::Matrix<double, N, 1> roots = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return roots.asDiagonal() * solver.eigenvectors().transpose();
}

// A measurement a_from_b whose rotation about b's z axis was not observed: that rotation is set to
// the one of `a_from_b_expected` (any choice fits the measurement; this one keeps the residual's
// other components undistorted), and the information about it is marginalised out.
struct YawFreeMeasurement {
  Pose3 a_from_b;
  Matrix6d information;
};
[[nodiscard]] YawFreeMeasurement WithoutYaw(const Pose3& a_from_b,
                                            const Matrix6d& information,
                                            const Pose3& a_from_b_expected);

}  // namespace deepslam::graph
