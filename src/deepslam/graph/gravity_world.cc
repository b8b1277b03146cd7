#include "deepslam/graph/gravity_world.h"

#include <cmath>

#include "deepslam/core/angles.h"
#include "deepslam/geometry/upright.h"

namespace deepslam::graph {
namespace {

// Nearer to the vertical, noise decides where a view leads on the ground.
constexpr double kVerticalView_rad = 5.0 * kRadPerDeg;

// Unit vector across `up` along which a camera looks whose upper edge lies towards `image_up`.
Eigen::Vector3d ForwardOnGround(const Eigen::Vector3d& view,
                                const Eigen::Vector3d& image_up,
                                const Eigen::Vector3d& up) {
  const Eigen::Vector3d forward = view - up.dot(view) * up;
  if (forward.norm() > std::sin(kVerticalView_rad)) return forward.normalized();
  // Looking down, the image's upper edge lies ahead; looking up, its lower edge does.
  const Eigen::Vector3d ahead = up.dot(view) < 0 ? image_up : Eigen::Vector3d(-image_up);
  return (ahead - up.dot(ahead) * up).normalized();
}

}  // namespace

Pose3 GravityFromTracking(const Pose3& tracking_from_first_camera,
                          const std::optional<Plane>& ground_tracking,
                          QuarterTurn upright) {
  const Eigen::Matrix3d tracking_from_camera =
      tracking_from_first_camera.rotation.toRotationMatrix();
  const Eigen::Vector3d down_camera = Turned(Eigen::Vector3d(0, 1, 0), Inverse(upright));
  const Eigen::Vector3d image_up = -(tracking_from_camera * down_camera);
  const Eigen::Vector3d up = ground_tracking ? ground_tracking->normal.normalized() : image_up;
  Eigen::Vector3d origin = tracking_from_first_camera.translation_m;
  if (ground_tracking) origin -= ground_tracking->SignedDistance(origin) * up;

  Eigen::Matrix3d gravity_from_tracking;
  const Eigen::Vector3d forward = ForwardOnGround(tracking_from_camera.col(2), image_up, up);
  gravity_from_tracking.row(0) = forward;
  gravity_from_tracking.row(1) = up.cross(forward);
  gravity_from_tracking.row(2) = up;
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(gravity_from_tracking).normalized();
  return {rotation, -(rotation * origin)};
}

}  // namespace deepslam::graph
