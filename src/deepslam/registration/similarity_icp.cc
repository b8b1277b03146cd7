#include "deepslam/registration/similarity_icp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Cholesky>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/depth_noise.h"
#include "deepslam/geometry/normal_equations.h"

namespace deepslam::registration {
namespace {

using Vector7d = SevenEquations::Vector;
using Matrix7d = SevenEquations::Matrix;

// A model of the right kind is still some centimetres beside the object; matching closer than this
// means nothing.
constexpr double kModelSigma = 0.01;
// A measured depth this close to the model's, outside the segment, is neither for nor against it.
constexpr double kNeutralGap = 0.03;
// Silhouettes are cut out by the segmentation, not measured: half the say of a measured point.
constexpr double kSilhouetteWeight = 0.5;
// Below this cosine measured and model surface do not face the same way.
constexpr double kMinFacing = 0.2;
// A point outside the model whose normal is further than this from the model's lies beside an edge.
constexpr double kEdgeFacing = 0.6;
// A firm ground is this much surer than a soft one.
constexpr double kFirmGround = 0.1;

double TukeyWeight(double residual, double radius) {
  const double t = residual / radius;
  return t * t >= 1.0 ? 0.0 : (1.0 - t * t) * (1.0 - t * t);
}

double Truncated(double residual, double radius) {
  const double t = residual / radius;
  return std::min(1.0, t * t);
}

double PointSigma(double depth_sigma_m, double scale_m) {
  const double voxel_sigma = 0.29 * scale_m * kVoxelSize;  // uniform within a voxel
  return std::sqrt(depth_sigma_m * depth_sigma_m + kModelSigma * kModelSigma +
                   voxel_sigma * voxel_sigma);
}

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
    ++num_residuals_;
    if (weight == 0) return;
    std::array<double, 7> slopes;
    for (std::size_t k = 0; k < slopes.size(); ++k)
      slopes[k] = jacobian[static_cast<Eigen::Index>(k)];
    sums_.Add(slopes, residual, weight);
  }

  void Add(const MotionResidual& residual) {
    Add(MotionJacobian(residual.direction_object, residual.x_object_m),
        residual.residual_m,
        residual.weight);
  }

  [[nodiscard]] Matrix7d Hessian() const { return sums_.Hessian(); }
  [[nodiscard]] Vector7d Gradient() const { return sums_.Gradient(); }
  [[nodiscard]] bool empty() const { return num_residuals_ == 0; }

 private:
  SevenEquations sums_;
  int num_residuals_ = 0;
};

// A visible model point against the measurement in the pixel it falls into.
struct BackMatch {
  enum Kind { kUnknown, kAgrees, kSurface, kFree, kConflict } kind = kUnknown;
  double residual_m = 0;  // kSurface: along the normal; kFree: sideways
  Eigen::Vector3d normal_camera = Eigen::Vector3d::Zero();  // kSurface
  Eigen::Vector2d sideways_m =
      Eigen::Vector2d::Zero();  // kFree: from the silhouette to the model point
};

// Whether a pixel or one beside it measured the given depth: at an edge of the object, rounding
// decides which it is.
bool AgreesAround(const MeasuredView& view, int u, int v, double depth_m) {
  for (int y = v - 1; y <= v + 1; ++y) {
    for (int x = u - 1; x <= u + 1; ++x) {
      if (view.depth_m.Contains(x, y) && std::abs(view.depth_m(x, y) - depth_m) < kNeutralGap) {
        return true;
      }
    }
  }
  return false;
}

BackMatch MatchBack(const MeasuredView& view, const Eigen::Vector3d& q_camera, double radius_m) {
  BackMatch match;
  const auto pixel = view.camera.Project(q_camera);
  if (!pixel || !(pixel->cwiseAbs().maxCoeff() < 1e6)) return match;
  const int u = static_cast<int>(std::lround(pixel->x()));
  const int v = static_cast<int>(std::lround(pixel->y()));
  if (!view.depth_m.Contains(u, v) || view.depth_m(u, v) <= 0) return match;
  const double depth = view.depth_m(u, v);
  const double gap = depth - q_camera.z();
  if (view.mask(u, v) != 0) {
    const Eigen::Vector3d normal = view.normals(u, v).cast<double>();
    match.kind = BackMatch::kConflict;
    if (normal.isZero()) return std::abs(gap) < radius_m ? BackMatch() : match;
    match.residual_m = normal.dot(q_camera - view.camera.Unproject(pixel->x(), pixel->y(), depth));
    match.normal_camera = normal;
    if (std::abs(gap) < 2 * radius_m && std::abs(match.residual_m) < radius_m) {
      match.kind = BackMatch::kSurface;
    }
    return match;
  }
  if (AgreesAround(view, u, v, q_camera.z())) {
    match.kind = BackMatch::kAgrees;
    return match;
  }
  const std::int32_t nearest = view.nearest_object_pixel(u, v);
  if (gap < 0 || nearest < 0) return match;
  match.kind = BackMatch::kFree;
  match.sideways_m = {(u - nearest % view.mask.width()) * q_camera.z() / view.camera.fx,
                      (v - nearest / view.mask.width()) * q_camera.z() / view.camera.fy};
  match.residual_m = match.sideways_m.norm();
  return match;
}

// A view relative to the placed model.
struct PlacedView {
  PlacedView(const MeasuredView& view, const Similarity3& world_from_object)
      : PlacedView(view.world_from_camera.Inverse() * world_from_object) {}
  explicit PlacedView(const Similarity3& placed)
      : scale_m(placed.scale), camera_from_object(placed), object_from_camera(placed.Inverse()) {}
  // The camera's place, object units.
  [[nodiscard]] const Eigen::Vector3d& camera_object() const {
    return object_from_camera.translation_m;
  }
  double scale_m;
  SimilarityMatrix camera_from_object;
  SimilarityMatrix object_from_camera;
};

// MatchPoint(), which is not taken into its callers here, as others may call it.
inline PointMatch Match(const shape::ShapeModel& model,
                        const Eigen::Vector3d& point_object,
                        const Eigen::Vector3d& normal_object,
                        double scale_m) {
  const auto [distance, gradient] = model.At(point_object.cast<float>());
  const double length = gradient.norm();
  const double distance_m = distance * scale_m;
  PointMatch match{.distance_m = std::abs(distance_m), .plane_residual_m = distance_m};
  if (length < 1e-3) return match;
  match.facing = normal_object.dot(gradient.cast<double>()) / length;
  match.outward_object = gradient.cast<double>() / length;
  match.beside = distance_m > 0 && std::abs(match.facing) < kEdgeFacing;
  match.plane_residual_m =
      distance_m * match.facing;  // n . (x - eta(x)), eta = x - distance * gradient
  return match;
}

// `Residuals` has Add(MotionResidual): equations, or a list.
template <typename Residuals>
void AddForward(const shape::ShapeModel& model,
                const MeasuredView& view,
                const PlacedView& placed,
                double radius_m,
                const SimilarityIcpOptions& options,
                Residuals& residuals) {
  const double scale_m = placed.scale_m;
  const double share = std::min(1.0, view.patch_share * options.point_stride);
  const std::size_t stride = static_cast<std::size_t>(options.point_stride);
  for (std::size_t i = 0; i < view.points_camera.size(); i += stride) {
    const Eigen::Vector3d x = placed.object_from_camera * view.points_camera[i].cast<double>();
    const Eigen::Vector3d normal =
        placed.object_from_camera.rotation * view.normals_camera[i].cast<double>();
    const PointMatch match = Match(model, x, normal, scale_m);
    const Eigen::Vector3d x_m = scale_m * x;
    const double sigma = PointSigma(view.sigmas_m[i], scale_m);
    const double information = share / (sigma * sigma);
    const bool beside = options.both_directions && match.beside;
    if (match.facing >= kMinFacing && !beside) {
      const double weight = information * TukeyWeight(match.distance_m, radius_m);
      residuals.Add({-normal, x_m, match.plane_residual_m, weight * match.facing});
    } else if (beside) {
      // A flat surface that goes on past the model's edge: Eq. (1) is zero there wherever the edge
      // lies, and a table top would slide in its own plane.
      const double weight =
          information * TukeyWeight(match.distance_m, std::max(radius_m, options.edge_radius_m));
      residuals.Add({-match.outward_object, x_m, match.distance_m, kSilhouetteWeight * weight});
    }
  }
}

template <typename Residuals>
void AddBackward(VisibleSurface& visible,
                 const MeasuredView& view,
                 const PlacedView& placed,
                 double radius_m,
                 int point_stride,
                 Residuals& residuals) {
  const double scale_m = placed.scale_m;
  const double cell_m = VisibleSurface::kCellVoxels * kVoxelSize * scale_m;
  // Each point speaks for those that are left out.
  const double share = point_stride * std::min(1.0, std::pow(cell_m / view.patch_m, 2));
  const Eigen::Matrix3d& object_from_camera = placed.object_from_camera.rotation;
  const std::vector<SurfacePoint>& seen = visible.From(placed.camera_object());
  for (std::size_t i = 0; i < seen.size(); i += static_cast<std::size_t>(point_stride)) {
    const SurfacePoint& surface = seen[i];
    const Eigen::Vector3d q_camera = placed.camera_from_object * surface.point;
    const Eigen::Vector3d q_m = scale_m * surface.point;
    const BackMatch match = MatchBack(view, q_camera, radius_m);
    if (match.kind != BackMatch::kSurface && match.kind != BackMatch::kFree) continue;
    const double sigma = PointSigma(DepthSigmaM(q_camera.z()), scale_m);
    const double weight = share * TukeyWeight(match.residual_m, radius_m) / (sigma * sigma);
    if (match.kind == BackMatch::kSurface) {
      const Eigen::Vector3d normal = object_from_camera * match.normal_camera;
      const double facing = normal.dot(surface.normal);
      if (facing < kMinFacing) continue;
      residuals.Add({normal, q_m, match.residual_m, weight * facing});
    } else {
      for (int axis = 0; axis < 2; ++axis) {
        residuals.Add({object_from_camera.col(axis),
                       q_m,
                       match.sideways_m[axis],
                       kSilhouetteWeight * weight});
      }
    }
  }
}

// Of all views, for the pose they are placed at.
template <typename Residuals>
void AddViews(const shape::ShapeModel& model,
              VisibleSurface& visible,
              std::span<const MeasuredView* const> views,
              const Similarity3& world_from_object,
              double radius_m,
              const SimilarityIcpOptions& options,
              Residuals& residuals) {
  for (const MeasuredView* view : views) {
    if (view->empty()) continue;
    const PlacedView placed(*view, world_from_object);
    AddForward(model, *view, placed, radius_m, options, residuals);
    if (options.both_directions)
      AddBackward(visible, *view, placed, radius_m, options.point_stride, residuals);
  }
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
               options.upright_sigma_rad,
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

PointMatch MatchPoint(const shape::ShapeModel& model,
                      const Eigen::Vector3d& point_object,
                      const Eigen::Vector3d& normal_object,
                      double scale_m) {
  return Match(model, point_object, normal_object, scale_m);
}

DEEPSLAM_WIDE_VECTORS Similarity3 AlignShape(const shape::ShapeModel& model,
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
    AddViews(model, visible, views, current, radius_m, options, equations);
    if (equations.empty()) break;
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
  struct List {
    void Add(const MotionResidual& residual) {
      if (residual.weight > 0) residuals.push_back(residual);
    }
    std::vector<MotionResidual> residuals;
  } list;
  AddViews(model, visible, views, world_from_object, radius_m, options, list);
  return std::move(list.residuals);
}

DEEPSLAM_WIDE_VECTORS double Disagreement(const shape::ShapeModel& model,
                                          VisibleSurface& visible,
                                          std::span<const MeasuredView* const> views,
                                          const Similarity3& world_from_object,
                                          double radius_m,
                                          int point_stride) {
  double forward = 0;
  double backward = 0;
  int num_forward = 0;
  int num_backward = 0;
  for (const MeasuredView* view : views) {
    if (view->empty()) continue;
    const PlacedView placed(*view, world_from_object);
    const std::size_t stride = static_cast<std::size_t>(std::max(1, point_stride));
    for (std::size_t i = 0; i < view->points_camera.size(); i += stride) {
      const PointMatch match =
          Match(model,
                placed.object_from_camera * view->points_camera[i].cast<double>(),
                placed.object_from_camera.rotation * view->normals_camera[i].cast<double>(),
                placed.scale_m);
      forward += match.facing < 0 ? 1.0 : Truncated(match.distance_m, radius_m);
      ++num_forward;
    }
    const std::vector<SurfacePoint>& seen = visible.From(placed.camera_object());
    for (std::size_t i = 0; i < seen.size(); i += stride) {
      const BackMatch match = MatchBack(*view, placed.camera_from_object * seen[i].point, radius_m);
      if (match.kind == BackMatch::kUnknown) continue;
      const bool conflict = match.kind == BackMatch::kConflict;
      backward += conflict ? 1.0 : Truncated(match.residual_m, radius_m);
      ++num_backward;
    }
  }
  return (num_forward > 0 ? forward / num_forward : 1.0) +
         (num_backward > 0 ? backward / num_backward : 1.0);
}

}  // namespace deepslam::registration
