#include "deepslam/alignment/gauss_newton.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>

#include "deepslam/core/angles.h"

namespace deepslam::alignment {
namespace {

constexpr float kMinPhotometricScale = 3.0F;  // grey levels: the noise of the camera itself
// Ends closer together than this are one place: iterations from either converge to it.
constexpr double kSameEndM = 0.005;
constexpr double kSameEndRad = 0.005;  // moves what is a metre away as far as kSameEndM

void TakeScales(const AlignmentSystem& system, bool near, AlignmentGates& gates) {
  // Scales only shrink: a step that makes things worse must not open the gates again.
  gates.geometric_scale = std::max(1.0F, std::min(gates.geometric_scale, system.geometric_scale));
  gates.photometric_scale =
      std::max(kMinPhotometricScale, std::min(gates.photometric_scale, system.photometric_scale));
  gates.gain = system.gain;
  gates.bias = system.bias;
  gates.falloff = near ? system.falloff : 0;
}

struct NormalEquations {
  Matrix6d hessian;
  Vector6d gradient;
};

// Near the place: depth and intensity each by the number of its independent measurements.
NormalEquations Balanced(const SourcePoints& points,
                         const AlignmentOptions& options,
                         GaussNewtonState& state) {
  const AlignmentSystem& system = state.system;
  const double of_depth = 1 / PixelsPerMeasurement(points, options.correlation_length_px);
  const double of_intensity =
      1 / PixelsPerMeasurement(points, options.photometric_correlation_length_px);
  const Matrix6d geometric = of_depth * (system.hessian - system.photometric_hessian);
  const Vector6d gradient = of_depth * (system.gradient - system.photometric_gradient);
  if (!ComparesImages(system.num_photometric)) return {geometric, gradient};
  if (!state.structural) state.structural = StructuralShare(geometric);
  const Matrix6d& share = *state.structural;
  const Matrix6d structural = share * geometric;
  return {0.5 * (structural + structural.transpose()) + of_intensity * system.photometric_hessian,
          share * gradient + of_intensity * system.photometric_gradient};
}

// Far off, where all that pulls is needed, every residual counts alike.
NormalEquations Measured(const SourcePoints& points,
                         const AlignmentOptions& options,
                         GaussNewtonState& state) {
  if (points.choice().near) return Balanced(points, options, state);
  const double share = 1 / PixelsPerMeasurement(points, options.correlation_length_px);
  return {share * state.system.hessian, share * state.system.gradient};
}

Vector6d Step(const GaussNewtonState& state, const NormalEquations& measured) {
  Vector6d prior;
  prior.head<3>().setConstant(1 / (kPriorSigma.translation_m * kPriorSigma.translation_m));
  prior.tail<3>().setConstant(1 / (kPriorSigma.rotation_rad * kPriorSigma.rotation_rad));
  const Vector6d moved = T2v(state.i_from_j * state.start_i_from_j.Inverse());
  Matrix6d hessian = measured.hessian;
  hessian.diagonal() += prior;
  const Vector6d gradient = measured.gradient + prior.cwiseProduct(moved);
  const Vector6d step = -hessian.ldlt().solve(gradient);
  return step.allFinite() ? step : Vector6d::Zero();
}

Vector6d InMetres(const Vector6d& step) {
  Vector6d metres = step;
  metres.tail<3>() *= kConvergedDistanceM;
  return metres;
}

}  // namespace

GaussNewtonState StartAt(const Pose3& start_i_from_j) {
  GaussNewtonState state;
  state.i_from_j = state.start_i_from_j = start_i_from_j;
  return state;
}

AlignmentGates LevelGates(const AlignmentOptions& options, std::size_t num_coarser) {
  AlignmentGates gates;
  gates.max_distance_m =
      static_cast<float>(options.max_distance_m / std::pow(2.0, static_cast<double>(num_coarser)));
  gates.min_normal_cosine =
      static_cast<float>(std::cos(AlignmentOptions::kMaxNormalAngle_deg * kRadPerDeg));
  return gates;
}

bool Iterate(const PyramidLevel& i,
             const SourcePoints& j,
             const AlignmentOptions& options,
             GaussNewtonState& state,
             std::span<const Pose3> known) {
  const bool near = j.choice().near;
  state.structural.reset();
  AndersonMixing mixing;
  ConvergenceEstimate convergence;
  for (int n = 0; n < options.max_iterations; ++n) {
    state.system = BuildAlignmentSystem(i, j, state.i_from_j, state.gates, options.pyramid.noise);
    state.stride = j.choice().stride;
    TakeScales(state.system, near, state.gates);
    const Vector6d unconstrained = Step(state, Measured(j, options, state));
    const Vector6d step = unconstrained - state.fixed.Component(unconstrained);
    // Far off the next stripe or tile may lie where the steps seem to lead.
    const Vector6d move = near ? mixing.Move(step) : step;
    state.i_from_j = V2t(move) * state.i_from_j;
    if (IsAmong(known, state.i_from_j)) return false;
    if (convergence.RemainingPx(step, j.level().camera.fx) < state.converged_px) break;
  }
  return true;
}

bool IsSamePlace(const Pose3& a, const Pose3& b) {
  const Pose3 difference = a.Inverse() * b;
  return difference.translation_m.norm() < kSameEndM &&
         RotationAngle(difference.rotation) < kSameEndRad;
}

bool IsAmong(std::span<const Pose3> places, const Pose3& place) {
  return std::ranges::any_of(places, [&](const Pose3& one) { return IsSamePlace(one, place); });
}

double PixelsPerMeasurement(const PyramidLevel& level, int stride, double length_at_640_px) {
  const double length_px = length_at_640_px * level.camera.width / (640.0 * stride);
  return std::max(1.0, length_px * length_px);
}

double PixelsPerMeasurement(const SourcePoints& points, double length_at_640_px) {
  return PixelsPerMeasurement(points.level(), points.choice().stride, length_at_640_px);
}

Vector6d AndersonMixing::Move(const Vector6d& step) {
  // Steps that shrink by the same share each time are taken further at once, by at most so many
  // times the last one; steps that swing, back by at most half.
  constexpr double kMostFurther = 2;
  constexpr double kMostBack = 0.5;  // of the last move
  Vector6d move = step;
  if (is_under_way_) {
    const Vector6d change = step - last_step_;
    const Vector6d change_m = InMetres(change);
    const double squared = change_m.squaredNorm();
    const double further = squared > 0 ? -InMetres(step).dot(change_m) / squared : 0;
    move += std::clamp(further, -kMostBack, kMostFurther) * (last_move_ + change);
  }
  is_under_way_ = true;
  last_step_ = step;
  last_move_ = move;
  return move;
}

double ConvergenceEstimate::RemainingPx(const Vector6d& step, double focal_px) {
  constexpr double kMostShrinking = 0.5;  // by which steps are taken to shrink
  const double step_px =
      focal_px * std::max(step.head<3>().norm() / kConvergedDistanceM, step.tail<3>().norm());
  const double share = last_px_ > 0 ? std::min(step_px / last_px_, kMostShrinking) : kMostShrinking;
  last_px_ = step_px;
  return step_px * share / (1 - share);
}

}  // namespace deepslam::alignment
