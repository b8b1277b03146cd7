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

// Colours of row v; white where nothing is hit.
std::vector<Eigen::Vector3f> ShadedRow(const RayScene& scene,
                                       std::span<const ShadedMesh* const> placed,
                                       const PinholeCamera& camera,
                                       const Pose3& world_from_camera,
                                       int v) {
  const auto width = static_cast<std::size_t>(camera.width);
  std::vector<RayHit> hits(width);
  std::vector<float> depth_m(width);
  RenderRow(scene, camera, world_from_camera, v, hits, depth_m);
  std::vector<Eigen::Vector3f> colours(width, Eigen::Vector3f::Constant(255.0f));
  for (std::size_t n = 0; n < width; ++n) {
    if (hits[n].instance < 0) continue;
    const Eigen::Vector3d p_camera =
        camera.Unproject(static_cast<int>(n), v, static_cast<double>(depth_m[n]));
    const Eigen::Vector3d point = world_from_camera * p_camera;
    const Eigen::Vector3d to_eye = (world_from_camera.translation_m - point).normalized();
    colours[n] = ShadePixel(scene, placed, hits[n], point.cast<float>(), to_eye.cast<float>());
  }
  return colours;
}

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
    std::vector<Eigen::Vector3f> sums(static_cast<std::size_t>(camera.width),
                                      Eigen::Vector3f::Zero());
    for (int fine_v = v * kSupersampling; fine_v < (v + 1) * kSupersampling; ++fine_v) {
      const std::vector<Eigen::Vector3f> colours =
          ShadedRow(scene, placed, fine, world_from_camera, fine_v);
      for (std::size_t n = 0; n < colours.size(); ++n) sums[n / kSupersampling] += colours[n];
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
