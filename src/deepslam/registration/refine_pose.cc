#include "deepslam/registration/refine_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include "deepslam/geometry/pose.h"

namespace deepslam::registration {
namespace {

// Of the robust weights, round by round: the first still reaches a start 5 cm beside.
constexpr std::array kRadii_m = {0.08, 0.06, 0.045, 0.035, 0.03, 0.03};
// Residuals beyond are of a model that is not quite the object: they count by length, not square.
constexpr double kCore_m = 0.01;
constexpr int kMaxIterations = 10;  // of a round
// Of the log of the scale: keeps equal bounds apart; the result is clamped.
constexpr double kConverged = 1e-4;

// (translation m; rotation vector; log scale) of a motion in the metric object frame.
using Motion = std::array<double, 7>;

struct AlongDirection {
  template <typename T>
  bool operator()(const T* motion, T* residual) const {
    const Eigen::Matrix<T, 3, 1> x = residual_at_rest.x_object_m.cast<T>();
    Eigen::Matrix<T, 3, 1> moved;
    ceres::AngleAxisRotatePoint(motion + 3, x.data(), moved.data());
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> translation(motion);
    moved = exp(motion[6]) * moved + translation - x;
    const T along = residual_at_rest.direction_object.cast<T>().dot(moved);
    residual[0] = sqrt_weight * (residual_at_rest.residual_m + along);
    return true;
  }
  MotionResidual residual_at_rest;
  double sqrt_weight;
};

struct Upright {
  template <typename T>
  bool operator()(const T* motion, T* residual) const {
    const std::array<T, 3> back = {-motion[3], -motion[4], -motion[5]};
    const Eigen::Matrix<T, 3, 1> up = up_object.cast<T>();
    Eigen::Matrix<T, 3, 1> turned;
    ceres::AngleAxisRotatePoint(back.data(), up.data(), turned.data());
    residual[0] = turned.x() / sigma_rad;
    residual[1] = turned.y() / sigma_rad;
    return true;
  }
  Eigen::Vector3d up_object;
  double sigma_rad;
};

struct NearSize {
  template <typename T>
  bool operator()(const T* motion, T* residual) const {
    residual[0] = (log_ratio + motion[6]) / sigma;
    return true;
  }
  double log_ratio;  // of the scale to the expected one
  double sigma;
};

void AddResidual(const MotionResidual& residual,
                 double core_m,
                 Motion& motion,
                 ceres::Problem& problem) {
  const double sqrt_weight = std::sqrt(residual.weight);
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<AlongDirection, 1, 7>(
                               new AlongDirection{residual, sqrt_weight}),
                           new ceres::HuberLoss(sqrt_weight * core_m),
                           motion.data());
}

void AddPriors(const shape::ShapeModel& model,
               std::span<const MeasuredView* const> views,
               const Similarity3& world_from_object,
               const SimilarityIcpOptions& options,
               Motion& motion,
               ceres::Problem& problem) {
  const MeasuredView& view = *views.front();
  const Eigen::Quaterniond object_from_world = world_from_object.rotation.conjugate();
  if (options.upright_sigma_rad > 0) {
    const Eigen::Vector3d up_world = view.world_from_camera.rotation * view.up_camera;
    const double sigma_rad = UprightSigma(view, static_cast<int>(views.size()), options);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Upright, 2, 7>(
                                 new Upright{object_from_world * up_world, sigma_rad}),
                             nullptr,
                             motion.data());
  }
  if (options.ground_sigma_m > 0 && view.ground_world) {
    const Eigen::Vector3d bottom(0, 0, model.bottom());
    const MotionResidual gap = {
        object_from_world * view.ground_world->normal,
        world_from_object.scale * bottom,
        view.ground_world->SignedDistance(world_from_object * bottom),
        static_cast<double>(views.size()) / (options.ground_sigma_m * options.ground_sigma_m)};
    AddResidual(gap, 3 * options.ground_sigma_m, motion, problem);
  }
  if (options.expected_scale_m > 0 && options.size_sigma > 0) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<NearSize, 1, 7>(new NearSize{
            std::log(world_from_object.scale / options.expected_scale_m), options.size_sigma}),
        nullptr,
        motion.data());
  }
}

// What Ceres makes of the motion that the problem is of; none where it finds nothing usable.
void Solve(ceres::Problem& problem, Motion& motion) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = kMaxIterations;
  solver.num_threads = 1;  // sums in one order
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  const bool is_finite =
      std::all_of(motion.begin(), motion.end(), [](double value) { return std::isfinite(value); });
  if (!summary.IsSolutionUsable() || !is_finite) motion = {};
}

Similarity3 Moved(const Similarity3& world_from_object,
                  const Motion& motion,
                  const SimilarityIcpOptions& options) {
  const Eigen::Map<const Vector6d> rigid(motion.data());
  const double scale = std::clamp(
      world_from_object.scale * std::exp(motion[6]), options.min_scale_m, options.max_scale_m);
  return Similarity3::From(world_from_object.RigidPart() * V2t(rigid), scale);
}

bool IsFinite(const Similarity3& pose) {
  return std::isfinite(pose.scale) && pose.scale > 0 && pose.rotation.coeffs().allFinite() &&
         pose.translation_m.allFinite();
}

std::vector<const MeasuredView*> WithPoints(std::span<const MeasuredView* const> views) {
  std::vector<const MeasuredView*> with;
  std::copy_if(views.begin(), views.end(), std::back_inserter(with), [](const auto* view) {
    return !view->empty();
  });
  return with;
}

}  // namespace

Similarity3 RefinePose(const shape::ShapeModel& model,
                       VisibleSurface& visible,
                       std::span<const MeasuredView* const> all_views,
                       const Similarity3& world_from_object,
                       const SimilarityIcpOptions& options) {
  const std::vector<const MeasuredView*> views = WithPoints(all_views);
  if (views.empty() || model.empty() || !IsFinite(world_from_object)) return world_from_object;
  Similarity3 current = world_from_object;
  current.scale = std::clamp(current.scale, options.min_scale_m, options.max_scale_m);
  for (const double radius_m : kRadii_m) {
    const std::vector<MotionResidual> residuals =
        ResidualsAt(model, visible, views, current, radius_m, options);
    if (residuals.empty()) break;
    Motion motion{};
    ceres::Problem problem;
    for (const MotionResidual& residual : residuals)
      AddResidual(residual, kCore_m, motion, problem);
    AddPriors(model, views, current, options, motion, problem);
    problem.SetParameterLowerBound(
        motion.data(), 6, std::log(options.min_scale_m / current.scale) - kConverged);
    problem.SetParameterUpperBound(
        motion.data(), 6, std::log(options.max_scale_m / current.scale) + kConverged);
    Solve(problem, motion);
    current = Moved(current, motion, options);
  }
  return current;
}

}  // namespace deepslam::registration
