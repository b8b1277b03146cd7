#include "deepslam/ground/plane_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Cholesky>

#include "deepslam/core/angles.h"
#include "deepslam/geometry/upright.h"

namespace deepslam::ground {
namespace {

constexpr int kMaxPlanes = 4;             // of a keyframe: floor, two table tops and a shelf
constexpr double kCandidateShare = 0.03;  // smaller planes are chance
// Enough to rank planes: a share of 3 % is known to half a per cent.
constexpr std::size_t kScoredPoints = 1500;
// Floors are flat to about a centimetre; beyond that the noise of the depth decides.
constexpr double kFlatnessM = 0.01;
constexpr double kSearchCosine = 0.9;          // 26 deg: normals of single points are noisy
constexpr double kReidentifyDistanceM = 0.04;  // error of a plane propagated over one keyframe step
constexpr int kPlaneSteps = 8;  // the gate shrinks from 4 cm by 0.7 each: at 1 cm after four

bool OnPlane(const GroundPoint& point,
             const Eigen::Vector3f& normal,
             float d,
             float distance,
             float cosine) {
  return std::abs(normal.dot(point.p_camera) + d) <= distance + 2 * point.sigma_m &&
         normal.dot(point.normal_camera) >= cosine;
}

// Weighted least-squares step of n . p + d about the plane; the Hessian is in units of information.
struct FitSystem {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  int num_inliers = 0;
};

FitSystem BuildFit(std::span<const GroundPoint> points, const Plane& plane, double gate_m) {
  const Eigen::Matrix<double, 3, 2> basis = GroundTangentBasis(plane.normal);
  const Eigen::Vector3f normal = plane.normal.cast<float>();
  FitSystem system;
  for (const GroundPoint& point : points) {
    if (normal.dot(point.normal_camera) < static_cast<float>(kReidentifyCosine)) continue;
    const Eigen::Vector3d p = point.p_camera.cast<double>();
    const double residual = plane.SignedDistance(p);
    const double limit = gate_m + 3 * static_cast<double>(point.sigma_m);
    if (std::abs(residual) >= limit) continue;
    const double tukey = std::pow(1 - std::pow(residual / limit, 2), 2);
    // Noise along the ray seen along the normal, and the unevenness of floors.
    const double along = static_cast<double>(point.sigma_m) * std::abs(plane.normal.dot(p)) / p.z();
    const double weight = tukey / (along * along + 0.25 * kFlatnessM * kFlatnessM);
    const Eigen::Vector3d jacobian(basis.col(0).dot(p), basis.col(1).dot(p), 1.0);
    system.hessian += weight * jacobian * jacobian.transpose();
    system.gradient += weight * residual * jacobian;
    ++system.num_inliers;
  }
  return system;
}

std::optional<Plane> FitStep(const FitSystem& system, const Plane& plane) {
  if (system.num_inliers < kMinPlanePoints) return std::nullopt;
  const Eigen::Vector3d step = -system.hessian.ldlt().solve(system.gradient);
  if (!step.allFinite() || step.head<2>().norm() > 0.5) return std::nullopt;
  return Perturbed(plane, step);
}

Eigen::Matrix3d Information(const FitSystem& system, double points_per_error) {
  Eigen::Matrix3d hessian = system.hessian / points_per_error;
  hessian.diagonal().array() += 1e-3;  // keeps a thin strip of ground invertible
  Eigen::Matrix3d covariance = hessian.ldlt().solve(Eigen::Matrix3d::Identity());
  const double floor_rad = GroundOptions::kFloorAngle_deg * kRadPerDeg;
  covariance.diagonal() += Eigen::Vector3d(
      floor_rad * floor_rad, floor_rad * floor_rad, std::pow(GroundOptions::kFloorDistance_m, 2));
  const Eigen::Matrix3d information =
      (0.5 * (covariance + covariance.transpose())).ldlt().solve(Eigen::Matrix3d::Identity());
  return 0.5 * (information + information.transpose());
}

// The point whose normal makes the plane with the most support among every score_step-th of the
// points left.
std::optional<Plane> DrawPlane(std::span<const GroundPoint> left,
                               QuarterTurn upright,
                               Random& random) {
  const std::size_t score_step = std::max<std::size_t>(1, left.size() / kScoredPoints);
  std::optional<Plane> best;
  int best_count = 0;
  for (int draw = 0; draw < GroundOptions::kNumRansacDraws; ++draw) {
    const GroundPoint& point = left[random.Index(left.size())];
    const Plane plane{point.normal_camera.cast<double>(),
                      -static_cast<double>(point.normal_camera.dot(point.p_camera))};
    if (!PermissibleOrientation(plane, upright) || plane.d_m <= 0) continue;
    int count = 0;
    for (std::size_t k = 0; k < left.size(); k += score_step) {
      count += OnPlane(left[k],
                       point.normal_camera,
                       static_cast<float>(plane.d_m),
                       static_cast<float>(2 * kFlatnessM),
                       static_cast<float>(kSearchCosine))
                   ? 1
                   : 0;
    }
    if (count > best_count) {
      best_count = count;
      best = plane;
    }
  }
  return best;
}

}  // namespace

double CoveredAreaM2(const GroundPoints& points, const PinholeCamera& camera, const Plane& plane) {
  const Eigen::Vector3f normal = plane.normal.cast<float>();
  double area_m2 = 0;
  for (const GroundPoint& point : points.points) {
    if (!OnPlane(point,
                 normal,
                 static_cast<float>(plane.d_m),
                 static_cast<float>(kFlatnessM),
                 static_cast<float>(kReidentifyCosine))) {
      continue;
    }
    const double z = static_cast<double>(point.p_camera.z());
    const double facing = -static_cast<double>(normal.dot(point.p_camera.normalized()));
    area_m2 +=
        z * z * points.step_px * points.step_px / (camera.fx * camera.fy) / std::max(facing, 0.1);
  }
  return area_m2;
}

Eigen::Matrix3d InformationOf(double angle_rad, double distance_m) {
  return Eigen::Vector3d(1 / (angle_rad * angle_rad),
                         1 / (angle_rad * angle_rad),
                         1 / (distance_m * distance_m))
      .asDiagonal();
}

Plane Perturbed(const Plane& plane, const Eigen::Vector3d& tangent_and_distance) {
  const Eigen::Vector3d normal =
      (plane.normal + GroundTangentBasis(plane.normal) * tangent_and_distance.head<2>())
          .normalized();
  return {normal, plane.d_m + tangent_and_distance.z()};
}

bool PermissibleOrientation(const Plane& plane_camera, QuarterTurn upright) {
  const Eigen::Vector3d up = Turned(plane_camera.normal, upright);
  if (up.y() >= 0) return false;
  const double roll = std::asin(std::min(1.0, std::abs(up.x())));
  const double pitch_down = std::asin(std::clamp(-up.z(), -1.0, 1.0));
  return roll <= GroundOptions::kMaxRoll_deg * kRadPerDeg &&
         pitch_down <= GroundOptions::kMaxPitchDown_deg * kRadPerDeg &&
         pitch_down >= -GroundOptions::kMaxPitchUp_deg * kRadPerDeg;
}

std::vector<PlaneCandidate> FindPlanes(const GroundPoints& points,
                                       QuarterTurn upright,
                                       Random& random) {
  std::vector<PlaneCandidate> planes;
  std::vector<GroundPoint> left = points.points;
  const double num_points = static_cast<double>(left.size());
  while (static_cast<int>(planes.size()) < kMaxPlanes && left.size() >= 200) {
    std::optional<Plane> plane = DrawPlane(left, upright, random);
    for (int n = 0; plane && n < 4; ++n)
      plane = FitStep(BuildFit(left, *plane, 2 * kFlatnessM), *plane);
    if (!plane || !PermissibleOrientation(*plane, upright)) break;
    const Eigen::Vector3f normal = plane->normal.cast<float>();
    PlaneCandidate candidate{*plane, Eigen::Vector3d::Zero(), 0};
    int count = 0;
    std::vector<GroundPoint> rest;
    for (const GroundPoint& point : left) {
      if (!OnPlane(point,
                   normal,
                   static_cast<float>(plane->d_m),
                   static_cast<float>(2 * kFlatnessM),
                   static_cast<float>(kSearchCosine))) {
        rest.push_back(point);
        continue;
      }
      candidate.centroid_camera += point.p_camera.cast<double>();
      ++count;
    }
    candidate.share = count / num_points;
    if (candidate.share < kCandidateShare) break;
    candidate.centroid_camera /= count;
    planes.push_back(candidate);
    left = std::move(rest);
  }
  return planes;
}

std::optional<PlaneRefinement> RefinePlane(const GroundPoints& points,
                                           const PinholeCamera& camera,
                                           const Plane& predicted_camera) {
  Plane plane = predicted_camera;
  double gate_m = kReidentifyDistanceM;
  for (int n = 0; n < kPlaneSteps; ++n) {
    const std::optional<Plane> next = FitStep(BuildFit(points.points, plane, gate_m), plane);
    if (!next) return std::nullopt;
    plane = *next;
    gate_m = std::max(kFlatnessM, 0.7 * gate_m);
  }
  const double turn = std::acos(std::clamp(plane.normal.dot(predicted_camera.normal), -1.0, 1.0));
  if (turn > kMaxTurnRad || std::abs(plane.d_m - predicted_camera.d_m) > kMaxShiftM)
    return std::nullopt;
  const FitSystem system = BuildFit(points.points, plane, gate_m);
  const double length_points =
      GroundOptions::kCorrelationLength_px * camera.width / 640.0 / points.step_px;
  PlaneRefinement result;
  result.plane_camera = plane;
  result.information = Information(system, std::max(1.0, length_points * length_points));
  result.num_inliers = system.num_inliers;
  result.inlier_share =
      system.num_inliers / std::max(1.0, static_cast<double>(points.points.size()));
  result.area_m2 = CoveredAreaM2(points, camera, plane);
  return result;
}

}  // namespace deepslam::ground
