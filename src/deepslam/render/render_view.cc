#include "deepslam/render/render_view.h"

#include <vector>

#include "deepslam/core/parallel.h"

namespace deepslam::render {

RenderedView RenderView(const RayScene& scene,
                        const PinholeCamera& camera,
                        const Pose3& world_from_camera) {
  RenderedView view{DepthImage(camera.width, camera.height, 0.0f),
                    Image<RayHit>(camera.width, camera.height)};
  const Eigen::Matrix3d rotation = world_from_camera.rotation.toRotationMatrix();
  const Eigen::Vector3f origin = world_from_camera.translation_m.cast<float>();
  const auto width = static_cast<std::size_t>(camera.width);
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    std::vector<Eigen::Vector3f> directions(width);
    std::vector<double> lengths(width);
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray_camera = camera.Ray(u, v);
      const auto n = static_cast<std::size_t>(u);
      lengths[n] = ray_camera.norm();
      directions[n] = (rotation * (ray_camera / lengths[n])).cast<float>();
    }
    RayHit* const hits = view.hits.row(v);
    scene.CastFan(origin, directions, {hits, width});
    for (std::size_t n = 0; n < width; ++n) {
      if (hits[n].instance >= 0)
        view.depth_m.row(v)[n] = static_cast<float>(hits[n].distance_m / lengths[n]);
    }
  });
  return view;
}

}  // namespace deepslam::render
