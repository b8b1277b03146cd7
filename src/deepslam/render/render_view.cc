#include "deepslam/render/render_view.h"

#include "deepslam/core/parallel.h"

namespace deepslam::render {

RenderedView RenderView(const RayScene& scene,
                        const PinholeCamera& camera,
                        const Pose3& world_from_camera) {
  RenderedView view{DepthImage(camera.width, camera.height, 0.0f),
                    Image<RayHit>(camera.width, camera.height)};
  const Eigen::Matrix3d rotation = world_from_camera.rotation.toRotationMatrix();
  const Eigen::Vector3f origin = world_from_camera.translation_m.cast<float>();
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray_camera = camera.Ray(u, v);
      const double length = ray_camera.norm();
      const Eigen::Vector3d direction = rotation * (ray_camera / length);
      const std::optional<RayHit> hit = scene.Cast(origin, direction.cast<float>());
      if (!hit) continue;
      view.depth_m(u, v) = static_cast<float>(hit->distance_m / length);
      view.hits(u, v) = *hit;
    }
  });
  return view;
}

}  // namespace deepslam::render
