#include "deepslam/registration/initial_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace deepslam::registration {
namespace {

constexpr std::size_t kMomentPoints = 150;  // of a view, evenly: more hardly change its moments

using Points = std::vector<Eigen::Vector3d>;

struct Moments {
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  double spread = 0;  // rms distance from the centroid
};

Moments MomentsOf(const Points& points) {
  Moments moments;
  for (const Eigen::Vector3d& point : points) moments.centroid += point;
  moments.centroid /= static_cast<double>(points.size());
  for (const Eigen::Vector3d& point : points) {
    moments.spread += (point - moments.centroid).squaredNorm();
  }
  moments.spread = std::sqrt(moments.spread / static_cast<double>(points.size()));
  return moments;
}

Points MeasuredPoints(const MeasuredView& view) {
  Points points;
  const std::size_t stride = view.points_camera.size() / kMomentPoints + 1;
  for (std::size_t i = 0; i < view.points_camera.size(); i += stride) {
    points.push_back(view.points_camera[i].cast<double>());
  }
  return points;
}

// Rotation that takes the model's z to `up` and its direction at `azimuth_rad` to `towards_camera`,
// both of the camera frame and perpendicular to each other.
Eigen::Quaterniond UprightRotation(const Eigen::Vector3d& up,
                                   const Eigen::Vector3d& towards_camera,
                                   double azimuth_rad) {
  Eigen::Matrix3d camera_from_facing;  // facing frame: x towards the camera, z up
  camera_from_facing << towards_camera, up.cross(towards_camera), up;
  const Eigen::AngleAxisd facing_from_object(-azimuth_rad, Eigen::Vector3d::UnitZ());
  return Eigen::Quaterniond(camera_from_facing) * facing_from_object;
}

}  // namespace

std::vector<Similarity3> AlignByMoments(VisibleSurface& visible,
                                        const MeasuredView& view,
                                        int num_azimuths,
                                        double min_scale_m,
                                        double max_scale_m) {
  const Points measured = MeasuredPoints(view);
  if (measured.size() < 3) return {};
  const Moments seen = MomentsOf(measured);
  const Eigen::Vector3d to_camera = -seen.centroid;
  const double rise = to_camera.dot(view.up_camera);
  const Eigen::Vector3d level = to_camera - rise * view.up_camera;
  if (!(seen.spread > 1e-6) || !(level.norm() > 1e-6)) return {};
  const std::array<double, 2> elevations_rad = {0.0, std::atan2(rise, level.norm())};
  std::vector<Similarity3> alignments;
  for (const double elevation : elevations_rad) {
    for (int k = 0; k < num_azimuths; ++k) {
      const double azimuth = 2 * std::numbers::pi * k / num_azimuths;
      Points model;
      for (const SurfacePoint& surface : visible.From({std::cos(elevation) * std::cos(azimuth),
                                                       std::cos(elevation) * std::sin(azimuth),
                                                       std::sin(elevation)})) {
        model.push_back(surface.point.cast<double>());
      }
      if (model.size() < 3) continue;
      const Moments whole = MomentsOf(model);
      if (!(whole.spread > 1e-6)) continue;
      Similarity3& camera_from_object = alignments.emplace_back();
      camera_from_object.rotation = UprightRotation(view.up_camera, level.normalized(), azimuth);
      camera_from_object.scale = std::clamp(seen.spread / whole.spread, min_scale_m, max_scale_m);
      camera_from_object.translation_m =
          seen.centroid - camera_from_object.scale * (camera_from_object.rotation * whole.centroid);
    }
  }
  return alignments;
}

}  // namespace deepslam::registration
