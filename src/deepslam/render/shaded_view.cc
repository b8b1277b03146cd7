#include "deepslam/render/shaded_view.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/render/ray_scene.h"
#include "deepslam/render/render_view.h"

namespace deepslam::render {
namespace {

constexpr int kSupersampling = 2;
constexpr float kSky = 0.55f;   // share of light without direction
constexpr float kLamp = 0.35f;  // share of the lamp
constexpr float kHead =
    0.25f;  // share of a light at the eye, so that shadowed sides keep their shape
const Eigen::Vector3f kToLamp = Eigen::Vector3f(0.35f, 0.25f, 1.0f).normalized();

Eigen::Vector3f ToVector(Rgb8 c) { return Eigen::Vector3f(c.r, c.g, c.b); }

Eigen::Vector3f SurfaceColour(const ShadedMesh& mesh, const RayHit& hit) {
  if (!mesh.use_vertex_colours || mesh.mesh.colours.size() != mesh.mesh.vertices.size()) {
    return ToVector(mesh.colour);
  }
  const auto& face = mesh.mesh.faces[hit.face];
  return (1 - hit.weight_b - hit.weight_c) * ToVector(mesh.mesh.colours[face[0]]) +
         hit.weight_b * ToVector(mesh.mesh.colours[face[1]]) +
         hit.weight_c * ToVector(mesh.mesh.colours[face[2]]);
}

float Light(const RayScene& scene,
            const Eigen::Vector3f& point,
            const Eigen::Vector3f& normal,
            const Eigen::Vector3f& to_eye) {
  constexpr float kFar_m = 20.0f;
  float light = kSky * (0.75f + 0.25f * normal.z()) + kHead * std::abs(normal.dot(to_eye));
  const float facing = normal.dot(kToLamp);
  if (facing > 0 && !scene.Occluded(point + 2e-3f * normal, point + kFar_m * kToLamp)) {
    light += kLamp * facing;
  }
  return light;
}

Eigen::Vector3f ShadePixel(const RayScene& scene,
                           std::span<const ShadedMesh* const> placed,
                           const RayHit& hit,
                           const Eigen::Vector3f& point,
                           const Eigen::Vector3f& to_eye) {
  const Eigen::Vector3f colour =
      SurfaceColour(*placed[static_cast<std::size_t>(hit.instance)], hit);
  return colour * Light(scene, point, hit.normal_world, to_eye);
}

std::uint8_t Byte(float x) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(x, 0.0f, 255.0f)));
}

PinholeCamera Supersampled(const PinholeCamera& camera) {
  PinholeCamera fine = camera;
  fine.width *= kSupersampling;
  fine.height *= kSupersampling;
  fine.fx *= kSupersampling;
  fine.fy *= kSupersampling;
  fine.cx = (camera.cx + 0.5) * kSupersampling - 0.5;
  fine.cy = (camera.cy + 0.5) * kSupersampling - 0.5;
  return fine;
}

// Renders rows of the fine view and shades them.
class RowShader {
 public:
  RowShader(const RayScene& scene,
            std::span<const ShadedMesh* const> placed,
            const PinholeCamera& fine,
            const Pose3& world_from_camera)
      : scene_(scene),
        placed_(placed),
        fine_(fine),
        world_from_camera_(world_from_camera),
        hits_(static_cast<std::size_t>(fine.width)),
        depth_m_(hits_.size()) {}

  void Render(int v) {
    v_ = v;
    RenderRow(scene_, fine_, world_from_camera_, v, hits_, depth_m_);
  }

  // White where nothing is hit.
  [[nodiscard]] Eigen::Vector3f Shade(int u) const {
    const auto n = static_cast<std::size_t>(u);
    if (hits_[n].instance < 0) return Eigen::Vector3f::Constant(255.0f);
    const Eigen::Vector3d point =
        world_from_camera_ * fine_.Unproject(u, v_, static_cast<double>(depth_m_[n]));
    const Eigen::Vector3d to_eye = (world_from_camera_.translation_m - point).normalized();
    return ShadePixel(scene_, placed_, hits_[n], point.cast<float>(), to_eye.cast<float>());
  }

 private:
  const RayScene& scene_;
  std::span<const ShadedMesh* const> placed_;
  const PinholeCamera& fine_;
  const Pose3& world_from_camera_;
  int v_ = 0;
  std::vector<RayHit> hits_;
  std::vector<float> depth_m_;
};

}  // namespace

ColourImage ShadeView(std::span<const ShadedMesh> meshes,
                      const PinholeCamera& camera,
                      const Pose3& world_from_camera) {
  RayScene scene;
  std::vector<const ShadedMesh*> placed;
  for (const ShadedMesh& mesh : meshes) {
    if (scene.AddMesh(mesh.mesh, mesh.world_from_mesh).ok()) placed.push_back(&mesh);
  }
  scene.Commit();
  const PinholeCamera fine = Supersampled(camera);
  ColourImage picture(camera.width, camera.height);
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    RowShader shader(scene, placed, fine, world_from_camera);
    std::vector<Eigen::Vector3f> sums(static_cast<std::size_t>(camera.width),
                                      Eigen::Vector3f::Zero());
    for (int fine_v = v * kSupersampling; fine_v < (v + 1) * kSupersampling; ++fine_v) {
      shader.Render(fine_v);
      for (int u = 0; u < fine.width; ++u) {
        sums[static_cast<std::size_t>(u / kSupersampling)] += shader.Shade(u);
      }
    }
    constexpr float kShare = 1.0f / (kSupersampling * kSupersampling);
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3f mean = kShare * sums[static_cast<std::size_t>(u)];
      picture(u, v) = {Byte(mean.x()), Byte(mean.y()), Byte(mean.z())};
    }
  });
  return picture;
}

Pose3 LookAt(const Eigen::Vector3d& position_world, const Eigen::Vector3d& target_world) {
  const Eigen::Vector3d forward = (target_world - position_world).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d world_from_camera;
  world_from_camera.col(0) = right;
  world_from_camera.col(1) = forward.cross(right);
  world_from_camera.col(2) = forward;
  return {Eigen::Quaterniond(world_from_camera).normalized(), position_world};
}

Pose3 Overlook(const Box3& box_world,
               const PinholeCamera& camera,
               double azimuth_rad,
               double elevation_rad) {
  const double radius = 0.5 * box_world.Size().norm();
  const double half_angle = std::min(std::atan(0.5 * camera.width / camera.fx),
                                     std::atan(0.5 * camera.height / camera.fy));
  // The box's sphere fits exactly; furniture fills less of it, so half of the slack is taken back.
  const double distance = std::max(0.5, 0.85 * radius / std::sin(half_angle));
  const Eigen::Vector3d direction(std::cos(azimuth_rad) * std::cos(elevation_rad),
                                  std::sin(azimuth_rad) * std::cos(elevation_rad),
                                  std::sin(elevation_rad));
  return LookAt(box_world.Center() + distance * direction, box_world.Center());
}

}  // namespace deepslam::render
