#include "deepslam/registration/similarity_icp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Cholesky>

#include "deepslam/geometry/normal_equations.h"

namespace deepslam::registration {
namespace {

using Vector7d = SevenEquations::Vector;
using Matrix7d = SevenEquations::Matrix;

// A firm ground is this much surer than a soft one.
constexpr double kFirmGround = 0.1;

// d(n . x)/d(motion) of a point x that moves with the object (metric object frame).
Vector7d MotionJacobian(const Eigen::Vector3d& n_object, const Eigen::Vector3d& x_object_m) {
  Vector7d jacobian;
  jacobian << n_object, x_object_m.cross(n_object), n_object.dot(x_object_m);
  return jacobian;
}

// The normal equations of a small motion of the object in its own metric frame: (translation;
// rotation; log scale).
class Equations {
 public:
  void Add(const Vector7d& jacobian, double residual, double weight) {
    std::array<double, 7> slopes;
    for (std::size_t k = 0; k < slopes.size(); ++k)
      slopes[k] = jacobian[static_cast<Eigen::Index>(k)];
    sums_.Add(slopes, residual, weight);
  }

  [[nodiscard]] Matrix7d Hessian() const { return sums_.Hessian(); }
  [[nodiscard]] Vector7d Gradient() const { return sums_.Gradient(); }
  [[nodiscard]] SevenEquations& sums() { return sums_; }

 private:
  SevenEquations sums_;
};

MatchOptions MatchingAt(double radius_m, const SimilarityIcpOptions& options) {
  return {.radius_m = radius_m,
          .edge_radius_m = options.edge_radius_m,
          .both_directions = options.both_directions,
          .point_stride = options.point_stride};
}

void AddUpright(const Eigen::Vector3d& up_world,
                const Similarity3& world_from_object,
                double sigma,
                Equations& equations) {
  // Tilting by w moves the model's z to z + w x z; its part across the true up shall vanish.
  const Eigen::Vector3d up = world_from_object.rotation.conjugate() * up_world;
  const double weight = 1.0 / (sigma * sigma);
  Vector7d about_x = Vector7d::Zero();
  Vector7d about_y = Vector7d::Zero();
  about_x[3] = -1;
  about_y[4] = 1;
  equations.Add(about_x, -up.y(), weight);
  equations.Add(about_y, -up.x(), weight);
}

// Every view stands on the same ground, and what pulls a wrong model off it pulls in all views
// alike: the prior counts once per view.
void AddGround(const shape::ShapeModel& model,
               const Plane& ground_world,
               const Similarity3& world_from_object,
               int num_views,
               const SimilarityIcpOptions& options,
               Equations& equations) {
  const Eigen::Vector3d bottom(0, 0, model.bottom());
  const Eigen::Vector3d up = world_from_object.rotation.conjugate() * ground_world.normal;
  const double gap_m = ground_world.SignedDistance(world_from_object * bottom);
  const double sigma = options.ground_sigma_m * (options.ground_firm ? kFirmGround : 1.0);
  // Huber: an object that truly hangs or lies deeper must be able to say so.
  const double trust =
      options.ground_firm ? 1.0 : std::min(1.0, 3 * sigma / std::max(1e-9, std::abs(gap_m)));
  equations.Add(MotionJacobian(up, world_from_object.scale * bottom),
                gap_m,
                num_views * trust / (sigma * sigma));
}

void AddPriors(const shape::ShapeModel& model,
               const MeasuredView& any_view,
               int num_views,
               const Similarity3& start,
               const Similarity3& world_from_object,
               const SimilarityIcpOptions& options,
               Equations& equations) {
  if (options.upright_sigma_rad > 0) {
    AddUpright(any_view.world_from_camera.rotation * any_view.up_camera,
               world_from_object,
               UprightSigma(any_view, num_views, options),
               equations);
  }
  if (options.ground_sigma_m > 0 && any_view.ground_world) {
    AddGround(model, *any_view.ground_world, world_from_object, num_views, options, equations);
  }
  if (options.expected_scale_m > 0 && options.size_sigma > 0) {
    const double error = std::log(world_from_object.scale / options.expected_scale_m);
    equations.Add(Vector7d::Unit(6), error, 1.0 / (options.size_sigma * options.size_sigma));
  }
  if (options.hold_sigma_m > 0 && options.hold_sigma_rad > 0) {
    const Vector6d moved = T2v(start.RigidPart().Inverse() * world_from_object.RigidPart());
    for (int i = 0; i < 6; ++i) {
      const double sigma = i < 3 ? options.hold_sigma_m : options.hold_sigma_rad;
      equations.Add(Vector7d::Unit(i), moved[i], 1.0 / (sigma * sigma));
    }
  }
}

// The step, bounded so that a badly conditioned start cannot fling the model away.
Vector7d SolveStep(const Equations& equations, bool free_scale, double max_step_m) {
  Matrix7d hessian = equations.Hessian();
  Vector7d gradient = equations.Gradient();
  if (!free_scale) {
    hessian.row(6).setZero();
    hessian.col(6).setZero();
    gradient[6] = 0;
  }
  // Levenberg damping far below any real information; keeps unobserved directions where they are.
  const double damping = 1e-6 * std::max(1.0, hessian.diagonal().maxCoeff());
  hessian.diagonal().array() += damping;
  Vector7d step = -hessian.ldlt().solve(gradient);
  if (!step.allFinite()) return Vector7d::Zero();
  const double too_long = std::max({step.head<3>().norm() / max_step_m,
                                    step.segment<3>(3).norm() / 0.3,
                                    std::abs(step[6]) / 0.15});
  return too_long > 1 ? Vector7d(step / too_long) : step;
}

Similarity3 Moved(const Similarity3& world_from_object,
                  const Vector7d& step,
                  const SimilarityIcpOptions& options) {
  const Pose3 rigid = world_from_object.RigidPart() * V2t(step.head<6>());
  const double scale = options.free_scale ? std::clamp(world_from_object.scale * std::exp(step[6]),
                                                       options.min_scale_m,
                                                       options.max_scale_m)
                                          : world_from_object.scale;
  return Similarity3::From(rigid, scale);
}

const MeasuredView* FirstUsable(std::span<const MeasuredView* const> views) {
  const auto it =
      std::find_if(views.begin(), views.end(), [](auto* view) { return !view->empty(); });
  return it == views.end() ? nullptr : *it;
}

}  // namespace

double UprightSigma(const MeasuredView& any_view,
                    int num_views,
                    const SimilarityIcpOptions& options) {
  const int num_counted = any_view.ground_world ? num_views : 1;
  return options.upright_sigma_rad / std::sqrt(static_cast<double>(std::max(num_counted, 1)));
}

Similarity3 AlignShape(const shape::ShapeModel& model,
                       VisibleSurface& visible,
                       std::span<const MeasuredView* const> views,
                       const Similarity3& world_from_object,
                       const SimilarityIcpOptions& options) {
  const MeasuredView* const any_view = FirstUsable(views);
  if (any_view == nullptr || model.empty()) return world_from_object;
  Similarity3 current = world_from_object;
  current.scale = options.free_scale
                      ? std::clamp(current.scale, options.min_scale_m, options.max_scale_m)
                      : current.scale;
  for (int iteration = 0; iteration < options.num_iterations; ++iteration) {
    // Down to the fine radius over the first two thirds, then settle there.
    const double progress = std::min(1.0, 1.5 * iteration / std::max(1, options.num_iterations));
    const double radius_m =
        options.start_radius_m * std::pow(options.end_radius_m / options.start_radius_m, progress);
    Equations equations;
    int num_residuals = 0;
    for (const MeasuredView* view : views) {
      if (view->empty()) continue;
      num_residuals += AddResidualsOf(
          model, visible, *view, current, MatchingAt(radius_m, options), equations.sums());
    }
    if (num_residuals == 0) break;
    AddPriors(model,
              *any_view,
              static_cast<int>(views.size()),
              world_from_object,
              current,
              options,
              equations);
    const Vector7d step = SolveStep(equations, options.free_scale, options.start_radius_m);
    current = Moved(current, step, options);
    if (progress >= 1.0 && step.cwiseAbs().maxCoeff() < 1e-4) break;
  }
  return current;
}

std::vector<MotionResidual> ResidualsAt(const shape::ShapeModel& model,
                                        VisibleSurface& visible,
                                        std::span<const MeasuredView* const> views,
                                        const Similarity3& world_from_object,
                                        double radius_m,
                                        const SimilarityIcpOptions& options) {
  std::vector<MotionResidual> all;
  if (model.empty()) return all;
  for (const MeasuredView* view : views) {
    if (view->empty()) continue;
    const std::vector<MotionResidual> residuals =
        ResidualsOf(model, visible, *view, world_from_object, MatchingAt(radius_m, options));
    all.insert(all.end(), residuals.begin(), residuals.end());
  }
  return all;
}

double Disagreement(const shape::ShapeModel& model,
                    VisibleSurface& visible,
                    std::span<const MeasuredView* const> views,
                    const Similarity3& world_from_object,
                    double radius_m,
                    int point_stride) {
  if (model.empty()) return 2.0;
  Misfit forward, backward;
  for (const MeasuredView* view : views) {
    if (view->empty()) continue;
    const ViewMisfit misfit =
        MisfitOf(model, visible, *view, world_from_object, radius_m, point_stride);
    forward.sum += misfit.forward.sum;
    forward.count += misfit.forward.count;
    backward.sum += misfit.backward.sum;
    backward.count += misfit.backward.count;
  }
  const auto mean = [](const Misfit& misfit) {
    return misfit.count > 0 ? misfit.sum / misfit.count : 1.0;
  };
  return mean(forward) + mean(backward);
}

}  // namespace deepslam::registration
