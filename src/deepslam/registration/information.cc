#include "deepslam/registration/information.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "deepslam/core/angles.h"
#include "deepslam/registration/view_matches.h"

namespace deepslam::registration {
namespace {

Matrix6d Floor() {
  Vector6d sigma;
  sigma << 1.0, 1.0, 1.0, 10 * kRadPerDeg, 10 * kRadPerDeg, 180 * kRadPerDeg;
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

// J^T J of n . (x' - x) for a small motion of x in the camera frame.
Matrix6d ResidualHessian(const Eigen::Vector3d& normal, const Eigen::Vector3d& x) {
  Vector6d jacobian;
  jacobian << normal, x.cross(normal);
  return jacobian * jacobian.transpose();
}

}  // namespace

ViewFit FitOfView(const shape::ShapeModel& model,
                  const MeasuredView& view,
                  const Pose3& camera_from_object,
                  double scale_m,
                  double radius_m,
                  bool is_round) {
  ViewFit fit;
  const SimilarityMatrix object_from_camera(
      Similarity3::From(camera_from_object, scale_m).Inverse());
  Matrix6d hessian_camera = Matrix6d::Zero();
  double squares = 0;
  double noise_squares = 0;
  for (std::size_t i = 0; i < view.points_camera.size(); ++i) {
    const Eigen::Vector3d point = view.points_camera[i].cast<double>();
    const Eigen::Vector3d normal = view.normals_camera[i].cast<double>();
    const PointMatch match = MatchPoint(
        model, object_from_camera * point, object_from_camera.rotation * normal, scale_m);
    if (match.distance_m >= radius_m || match.facing <= 0) continue;
    ++fit.num_inliers;
    squares += match.plane_residual_m * match.plane_residual_m;
    noise_squares += std::pow(view.sigmas_m[i], 2);
    const double weight = match.facing * std::pow(1 - std::pow(match.distance_m / radius_m, 2), 2);
    hessian_camera += weight * ResidualHessian(normal, point);
  }
  Matrix6d hessian = Matrix6d::Zero();
  if (fit.num_inliers > 0) {
    const double count = fit.num_inliers;
    fit.inlier_share = count / static_cast<double>(view.points_camera.size());
    fit.rmse_m = std::sqrt(squares / count);
    const double variance = std::max(squares, noise_squares) / count;
    const Matrix6d adjoint = Adjoint(camera_from_object);
    hessian = adjoint.transpose() * hessian_camera * adjoint *
              (std::min(1.0, view.patch_share) / variance);
  }
  if (is_round) {
    hessian.row(5).setZero();
    hessian.col(5).setZero();
  }
  hessian += Floor();
  fit.information = 0.5 * (hessian + hessian.transpose());
  fit.yaw_sigma_rad = std::sqrt(std::max(0.0, fit.information.inverse()(5, 5)));
  return fit;
}

bool IsRound(const shape::ShapeModel& model, double share) {
  if (model.empty()) return false;
  const std::span<const Eigen::Vector3f> points = model.surface_points();
  const std::size_t stride = points.size() / 1000 + 1;
  for (const double degrees : {22.5, 45.0, 67.5, 90.0, 135.0}) {
    const Eigen::Matrix3f turn =
        Eigen::AngleAxisf(static_cast<float>(degrees * kRadPerDeg), Eigen::Vector3f::UnitZ())
            .toRotationMatrix();
    int covered = 0;
    int total = 0;
    for (std::size_t i = 0; i < points.size(); i += stride) {
      ++total;
      if (std::abs(model.Distance(turn * points[i])) < 1.5f * static_cast<float>(kVoxelSize)) {
        ++covered;
      }
    }
    if (covered < share * total) return false;
  }
  return true;
}

}  // namespace deepslam::registration
