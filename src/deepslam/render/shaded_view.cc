#include "deepslam/render/shaded_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/render/ray_scene.h"

namespace deepslam::render {
namespace {

constexpr int kSupersampling = 2;  // rays along a side of a pixel at an edge
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

float Light(const Eigen::Vector3f& normal, const Eigen::Vector3f& to_eye, bool sees_lamp) {
  const float light = kSky * (0.75f + 0.25f * normal.z()) + kHead * std::abs(normal.dot(to_eye));
  return sees_lamp ? light + kLamp * normal.dot(kToLamp) : light;
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

// Pixels that differ this much from one beside them, of 255, lie at an edge.
constexpr float kEdgeContrast = 6;

bool Differs(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return (a - b).cwiseAbs().maxCoeff() > kEdgeContrast;
}

bool IsAtEdge(const Image<Eigen::Vector3f>& colours, int u, int v) {
  const Eigen::Vector3f& middle = colours(u, v);
  return (u > 0 && Differs(middle, colours(u - 1, v))) ||
         (u + 1 < colours.width() && Differs(middle, colours(u + 1, v))) ||
         (v > 0 && Differs(middle, colours(u, v - 1))) ||
         (v + 1 < colours.height() && Differs(middle, colours(u, v + 1)));
}

// Looks through a camera.
class Eye {
 public:
  Eye(const PinholeCamera& camera, const Pose3& world_from_camera)
      : camera_(camera),
        rotation_(world_from_camera.rotation.toRotationMatrix()),
        position_(world_from_camera.translation_m.cast<float>()) {}

  [[nodiscard]] Eigen::Vector3f Direction(int u, int v) const {
    return (rotation_ * camera_.Ray(u, v).normalized()).cast<float>();
  }
  [[nodiscard]] const Eigen::Vector3f& position() const { return position_; }

 private:
  PinholeCamera camera_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3f position_;
};

// Which of the hits face the lamp with nothing between; 0 or 1.
std::vector<std::uint8_t> SeeLamp(const RayScene& scene,
                                  const Eigen::Vector3f& origin,
                                  std::span<const Eigen::Vector3f> directions,
                                  std::span<const RayHit> hits) {
  constexpr float kFar_m = 20.0f;  // length of a ray to the lamp: what is farther casts no shadow
  std::vector<std::size_t> facing;
  std::vector<Eigen::Vector3f> from;
  std::vector<Eigen::Vector3f> to;
  for (std::size_t n = 0; n < hits.size(); ++n) {
    if (hits[n].instance < 0 || hits[n].normal_world.dot(kToLamp) <= 0) continue;
    const Eigen::Vector3f point = origin + static_cast<float>(hits[n].distance_m) * directions[n];
    facing.push_back(n);
    from.emplace_back(point + 2e-3f * hits[n].normal_world);
    to.emplace_back(point + kFar_m * kToLamp);
  }
  std::vector<std::uint8_t> occluded(facing.size());
  scene.AreOccluded(from, to, occluded);
  std::vector<std::uint8_t> see(hits.size(), 0);
  for (std::size_t i = 0; i < facing.size(); ++i) see[facing[i]] = occluded[i] == 0 ? 1 : 0;
  return see;
}

// Colours of rays from the eye; white where nothing is hit.
std::vector<Eigen::Vector3f> ShadedRays(const RayScene& scene,
                                        std::span<const ShadedMesh* const> placed,
                                        const Eye& eye,
                                        std::span<const Eigen::Vector3f> directions) {
  std::vector<RayHit> hits(directions.size());
  scene.CastFan(eye.position(), directions, hits);
  const std::vector<std::uint8_t> see_lamp = SeeLamp(scene, eye.position(), directions, hits);
  std::vector<Eigen::Vector3f> colours(directions.size(), Eigen::Vector3f::Constant(255.0f));
  for (std::size_t n = 0; n < directions.size(); ++n) {
    const RayHit& hit = hits[n];
    if (hit.instance < 0) continue;
    colours[n] = SurfaceColour(*placed[static_cast<std::size_t>(hit.instance)], hit) *
                 Light(hit.normal_world, -directions[n], see_lamp[n] != 0);
  }
  return colours;
}

// One ray through each pixel's middle.
Image<Eigen::Vector3f> ShadedOnce(const RayScene& scene,
                                  std::span<const ShadedMesh* const> placed,
                                  const PinholeCamera& camera,
                                  const Pose3& world_from_camera) {
  const Eye eye(camera, world_from_camera);
  Image<Eigen::Vector3f> colours(camera.width, camera.height, Eigen::Vector3f::Zero());
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    std::vector<Eigen::Vector3f> directions;
    for (int u = 0; u < camera.width; ++u) directions.push_back(eye.Direction(u, v));
    std::ranges::copy(ShadedRays(scene, placed, eye, directions), colours.row(v));
  });
  return colours;
}

// Row v, with several rays through the pixels at edges.
std::vector<Eigen::Vector3f> SmoothRow(const RayScene& scene,
                                       std::span<const ShadedMesh* const> placed,
                                       const Eye& fine_eye,
                                       const Image<Eigen::Vector3f>& colours,
                                       int v) {
  std::vector<Eigen::Vector3f> row(colours.row(v), colours.row(v) + colours.width());
  std::vector<std::size_t> at_edge;
  std::vector<Eigen::Vector3f> directions;
  for (int u = 0; u < colours.width(); ++u) {
    if (!IsAtEdge(colours, u, v)) continue;
    at_edge.push_back(static_cast<std::size_t>(u));
    for (int n = 0; n < kSupersampling * kSupersampling; ++n) {
      directions.push_back(fine_eye.Direction(u * kSupersampling + n % kSupersampling,
                                              v * kSupersampling + n / kSupersampling));
    }
  }
  const std::vector<Eigen::Vector3f> fine = ShadedRays(scene, placed, fine_eye, directions);
  constexpr std::size_t kRays = kSupersampling * kSupersampling;
  for (std::size_t n = 0; n < at_edge.size(); ++n) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (std::size_t k = 0; k < kRays; ++k) sum += fine[n * kRays + k];
    row[at_edge[n]] = sum / static_cast<float>(kRays);
  }
  return row;
}

}  // namespace

struct ShadedScene::Impl {
  RayScene scene;
  std::vector<const ShadedMesh*> placed;
};

ShadedScene::ShadedScene(std::span<const ShadedMesh> meshes) : impl_(std::make_unique<Impl>()) {
  for (const ShadedMesh& mesh : meshes) {
    if (impl_->scene.AddMesh(mesh.mesh, mesh.world_from_mesh).ok()) impl_->placed.push_back(&mesh);
  }
  impl_->scene.Commit();
}
ShadedScene::~ShadedScene() = default;

ColourImage ShadedScene::View(const PinholeCamera& camera, const Pose3& world_from_camera) const {
  const Image<Eigen::Vector3f> colours =
      ShadedOnce(impl_->scene, impl_->placed, camera, world_from_camera);
  const Eye fine_eye(Supersampled(camera), world_from_camera);
  ColourImage picture(camera.width, camera.height);
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    const std::vector<Eigen::Vector3f> smooth =
        SmoothRow(impl_->scene, impl_->placed, fine_eye, colours, v);
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3f& mean = smooth[static_cast<std::size_t>(u)];
      picture(u, v) = {Byte(mean.x()), Byte(mean.y()), Byte(mean.z())};
    }
  });
  return picture;
}

ColourImage ShadeView(std::span<const ShadedMesh> meshes,
                      const PinholeCamera& camera,
                      const Pose3& world_from_camera) {
  return ShadedScene(meshes).View(camera, world_from_camera);
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
