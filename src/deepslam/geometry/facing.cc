#include "deepslam/geometry/facing.h"

namespace deepslam {

double BackShown(const Eigen::Quaterniond& world_from_object,
                 const Eigen::Vector3d& center_world,
                 std::span<const Eigen::Vector3d> cameras_world) {
  if (cameras_world.empty()) return 0.5;
  const Eigen::Vector3d up = world_from_object * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d front = world_from_object * Eigen::Vector3d::UnitX();
  double cosines = 0;
  for (const Eigen::Vector3d& camera : cameras_world) {
    Eigen::Vector3d to_camera = camera - center_world;
    to_camera -= up.dot(to_camera) * up;
    if (to_camera.norm() > 1e-6) cosines += front.dot(to_camera.normalized());
  }
  return 0.5 - 0.5 * cosines / static_cast<double>(cameras_world.size());
}

}  // namespace deepslam
