#include "deepslam/alignment/edge_information.h"

#include <algorithm>

#include <Eigen/Cholesky>

#include "deepslam/core/angles.h"

namespace deepslam::alignment {
namespace {

// The Hessian of a left perturbation as information of independent measurements, made positive
// semidefinite; and the share of its weakest direction.
struct ClampedHessian {
  Matrix6d left = Matrix6d::Zero();
  double ratio = 0;
};

// Along a direction in metres, rotations by their arc.
double InformationOfStart(const Vector6d& direction,
                          const Vector6d& scale,
                          const StartSigma& sigma) {
  Vector6d sigmas_m = scale;
  sigmas_m.head<3>() *= sigma.translation_m;
  sigmas_m.tail<3>() *= sigma.rotation_rad;
  return 1 / direction.cwiseProduct(sigmas_m).squaredNorm();
}

// What images show of the other directions.
Matrix6d Beside(const DegenerateDirections& fixed, const Matrix6d& hessian) {
  if (fixed.empty()) return hessian;
  Matrix6d others = Matrix6d::Identity();
  for (int k = 0; k < 6; ++k) others.col(k) -= fixed.Component(Vector6d::Unit(k));
  return others.transpose() * hessian * others;
}

ClampedHessian Clamped(const GaussNewtonState& state,
                       const PyramidLevel& finest,
                       const StartSigma& start_sigma,
                       const AlignmentOptions& options) {
  const AlignmentSystem& system = state.system;
  const Matrix6d photometric = Beside(state.fixed, system.photometric_hessian);
  const Matrix6d raw =
      (system.hessian - system.photometric_hessian) /
          PixelsPerMeasurement(finest, state.stride, options.correlation_length_px) +
      photometric /
          PixelsPerMeasurement(finest, state.stride, options.photometric_correlation_length_px);
  const std::optional<DirectionSpectrum> spectrum = SpectrumByArc(raw);
  if (!spectrum) return {};
  const Matrix6d& directions = spectrum->directions;
  const Vector6d& scale = spectrum->scale;
  Vector6d values = spectrum->values.cwiseMax(0.0);
  const bool by_depth_alone = !ComparesImages(system.num_photometric);
  const double least = by_depth_alone || !state.fixed.empty() ? kUnconstrainedRatio * values[5] : 0;
  double ratio = values[5] > 0 ? values[0] / values[5] : 0;
  const StartSigma& sigma = state.fixed_sigma ? *state.fixed_sigma : start_sigma;
  for (int k = 0; k < 6 && values[k] < least; ++k)
    values[k] = InformationOfStart(directions.col(k), scale, sigma);
  if (state.fixed_sigma && values[5] > 0) ratio = values.minCoeff() / values[5];
  const Matrix6d clamped = directions * values.asDiagonal() * directions.transpose();
  return {scale.asDiagonal() * clamped * scale.asDiagonal(), ratio};
}

// In frame j, of a right perturbation, with the prior and the systematic error.
Matrix6d Information(const Matrix6d& left,
                     const Pose3& i_from_j,
                     const StartSigma& start_sigma,
                     const AlignmentOptions& options) {
  // A perturbation in frame j (right) is Adjoint(i_from_j) times as large in frame i (left).
  const Matrix6d adjoint = Adjoint(i_from_j);
  Matrix6d right = adjoint.transpose() * left * adjoint;
  // Directions that nothing constrains keep the prior that held them.
  const double prior_m = std::max(kPriorSigma.translation_m, start_sigma.translation_m);
  const double prior_rad = std::max(kPriorSigma.rotation_rad, start_sigma.rotation_rad);
  right.diagonal().head<3>().array() += 1 / (prior_m * prior_m);
  right.diagonal().tail<3>().array() += 1 / (prior_rad * prior_rad);
  Matrix6d covariance = right.ldlt().solve(Matrix6d::Identity());
  covariance.diagonal().head<3>().array() +=
      options.floor_translation_m * options.floor_translation_m;
  const double floor_rad = options.floor_rotation_deg * kRadPerDeg;
  covariance.diagonal().tail<3>().array() += floor_rad * floor_rad;
  const Matrix6d information =
      (0.5 * (covariance + covariance.transpose())).ldlt().solve(Matrix6d::Identity());
  return 0.5 * (information + information.transpose());
}

}  // namespace

EdgeInformation EdgeInformationOf(const GaussNewtonState& state,
                                  const PyramidLevel& finest,
                                  const StartSigma& start_sigma,
                                  const AlignmentOptions& options) {
  const ClampedHessian clamped = Clamped(state, finest, start_sigma, options);
  return {Information(clamped.left, state.i_from_j, start_sigma, options), clamped.ratio};
}

}  // namespace deepslam::alignment
