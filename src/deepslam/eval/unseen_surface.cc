#include "deepslam/eval/unseen_surface.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "deepslam/core/check.h"

namespace deepslam::eval {
namespace {

// Three standard deviations of a Kinect's depth at 2 m; beyond, 2 % of the depth hold as many.
constexpr double kSeenWithinM = 0.03;
constexpr double kSeenWithinShare = 0.02;  // of the depth

bool Shows(const InstanceView& view, int number, const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d p_camera = view.camera_from_world * p_world;
  const std::optional<Eigen::Vector2d> pixel = view.camera.Project(p_camera);
  if (!pixel) return false;
  const Eigen::Vector2d rounded = pixel->array().round();
  const bool is_inside = rounded.x() >= 0 && rounded.y() >= 0 && rounded.x() < view.camera.width &&
                         rounded.y() < view.camera.height;  // false for NaN
  if (!is_inside) return false;
  const int u = static_cast<int>(rounded.x());
  const int v = static_cast<int>(rounded.y());
  const auto measured_m = static_cast<double>(view.depth_m(u, v));
  if (view.instances(u, v) != number || !(measured_m > 0)) return false;
  return std::abs(measured_m - p_camera.z()) <=
         std::max(kSeenWithinM, kSeenWithinShare * p_camera.z());
}

}  // namespace

void MarkSeen(const InstanceView& view,
              int number,
              std::span<const Eigen::Vector3d> points_world,
              std::vector<bool>& seen) {
  DEEPSLAM_CHECK(
      view.depth_m.width() == view.camera.width && view.depth_m.height() == view.camera.height &&
          view.instances.width() == view.camera.width &&
          view.instances.height() == view.camera.height && seen.size() == points_world.size(),
      "depth, instances and camera differ in size, or points and what was seen of them");
  for (std::size_t n = 0; n < seen.size(); ++n)
    seen[n] = seen[n] || Shows(view, number, points_world[n]);
}

double ShareOnSurface(const shape::ShapeModel& model,
                      const Similarity3& world_from_object,
                      std::span<const Eigen::Vector3d> points_world,
                      double tolerance_m) {
  if (points_world.empty() || model.empty()) return 0;
  const Similarity3 object_from_world = world_from_object.Inverse();
  const auto near = std::ranges::count_if(points_world, [&](const Eigen::Vector3d& p_world) {
    const Eigen::Vector3f p_object = (object_from_world * p_world).cast<float>();
    return world_from_object.scale * std::abs(model.Distance(p_object)) <= tolerance_m;
  });
  return static_cast<double>(near) / static_cast<double>(points_world.size());
}

}  // namespace deepslam::eval
