#include "deepslam/render/render_view.h"

#include <vector>

#include "deepslam/core/parallel.h"

namespace deepslam::render {

void RenderRow(const RayScene& scene,
               const PinholeCamera& camera,
               const Pose3& world_from_camera,
               int v,
               std::span<RayHit> hits,
               std::span<float> depth_m) {
  const Eigen::Matrix3d rotation = world_from_camera.rotation.toRotationMatrix();
  const auto width = static_cast<std::size_t>(camera.width);
  std::vector<Eigen::Vector3f> directions(width);
  std::vector<double> lengths(width);
  for (int u = 0; u < camera.width; ++u) {
    const Eigen::Vector3d ray_camera = camera.Ray(u, v);
    const auto n = static_cast<std::size_t>(u);
    lengths[n] = ray_camera.norm();
    directions[n] = (rotation * (ray_camera / lengths[n])).cast<float>();
  }
  scene.CastFan(world_from_camera.translation_m.cast<float>(), directions, hits);
  for (std::size_t n = 0; n < width; ++n) {
    depth_m[n] = hits[n].instance >= 0 ? static_cast<float>(hits[n].distance_m / lengths[n]) : 0.0f;
  }
}

RenderedView RenderView(const RayScene& scene,
                        const PinholeCamera& camera,
                        const Pose3& world_from_camera) {
  RenderedView view{DepthImage(camera.width, camera.height),
                    Image<RayHit>(camera.width, camera.height)};
  const auto width = static_cast<std::size_t>(camera.width);
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    RenderRow(scene,
              camera,
              world_from_camera,
              v,
              {view.hits.row(v), width},
              {view.depth_m.row(v), width});
  });
  return view;
}

}  // namespace deepslam::render
