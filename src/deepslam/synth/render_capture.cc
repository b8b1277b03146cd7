#include "deepslam/synth/render_capture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/render/ray_scene.h"
#include "deepslam/render/render_view.h"
#include "deepslam/synth/camera_path.h"
#include "deepslam/synth/lighting.h"
#include "deepslam/synth/painted_part.h"
#include "deepslam/synth/sensor_faults.h"
#include "deepslam/synth/surface_pattern.h"
#include "deepslam/synth/table_top.h"

namespace deepslam::synth {
namespace {

// Through a door or window: a bright day, display intensity.
const Eigen::Vector3f kOutside(0.75f, 0.82f, 0.9f);

std::vector<Eigen::Vector3f> LinearColours(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> colours;
  for (const Rgb8& colour : mesh.colours) colours.push_back(Linear(colour));
  colours.resize(mesh.vertices.size(), Linear({180, 180, 180}));
  return colours;
}

}  // namespace

struct CaptureRenderer::Impl {
  World world;
  render::RayScene scene;
  std::vector<PaintedPart> painted;
  std::vector<Pose3> path;
  std::vector<int> kept;
  // Of the objects, then of the clutter: instances after the room's parts.
  std::vector<std::vector<Eigen::Vector3f>> thing_colours;  // linear, per vertex
  std::vector<std::optional<TableTop>> tops;                // of tables, where tops are blind
  std::vector<Eigen::Isometry3d> object_from_world;

  explicit Impl(World the_world)
      : world(std::move(the_world)),
        path(CameraPath(world.description)),
        kept(KeptFrames(world.description)) {
    for (const RoomPart& part : world.room) {
      const Result<int> added = scene.AddMesh(part.mesh, Pose3());
      DEEPSLAM_CHECK(added.ok(), "a room's part is a mesh");
      painted.emplace_back(part, world.description);
    }
    for (const PlacedObject& object : world.objects) {
      const Result<int> added = scene.AddMesh(object.mesh, object.world_from_object);
      DEEPSLAM_CHECK(added.ok(), "BuildWorld checks the models");
      thing_colours.push_back(LinearColours(object.mesh));
      object_from_world.emplace_back(object.world_from_object.Inverse().Matrix());
      tops.emplace_back();
      if (world.description.faults.table_edges_m > 0 && object.has_support_plane)
        tops.back().emplace(object.mesh);
    }
    for (const TriangleMesh& mesh : world.clutter) {
      const Result<int> added = scene.AddMesh(mesh, Pose3());
      DEEPSLAM_CHECK(added.ok(), "clutter is made of meshes");
      thing_colours.push_back(LinearColours(mesh));
    }
    scene.Commit();
  }

  [[nodiscard]] int NumRoomParts() const { return static_cast<int>(world.room.size()); }
  // Number of the object that was hit; nothing for the room and clutter.
  [[nodiscard]] std::optional<std::size_t> ObjectOf(const render::RayHit& hit) const {
    const int o = hit.instance - NumRoomParts();
    if (o < 0 || o >= static_cast<int>(world.objects.size())) return std::nullopt;
    return static_cast<std::size_t>(o);
  }

  [[nodiscard]] Eigen::Vector3f Reflectance(const render::RayHit& hit,
                                            const Eigen::Vector3d& p_world,
                                            double footprint_m) const {
    if (hit.instance < NumRoomParts())
      return painted[static_cast<std::size_t>(hit.instance)].At(p_world, footprint_m);
    const auto t = static_cast<std::size_t>(hit.instance - NumRoomParts());
    const bool is_object = t < world.objects.size();
    const TriangleMesh& mesh =
        is_object ? world.objects[t].mesh : world.clutter[t - world.objects.size()];
    const std::array<std::uint32_t, 3>& face = mesh.faces[hit.face];
    const std::vector<Eigen::Vector3f>& colours = thing_colours[t];
    const Eigen::Vector3f base = (1 - hit.weight_b - hit.weight_c) * colours[face[0]] +
                                 hit.weight_b * colours[face[1]] + hit.weight_c * colours[face[2]];
    // Nothing real is of one colour only: a faint grain, coarser than a pixel.
    const Eigen::Vector3d p = is_object ? object_from_world[t] * p_world : p_world;
    const double grain = 0.06 * SmoothNoise(p / 0.02, world.description.seed + t) +
                         0.05 * SmoothNoise(p / 0.15, world.description.seed + t + 100);
    return (base * static_cast<float>(1 + grain)).cwiseMax(0.0f).cwiseMin(1.0f);
  }

  // What the depth camera makes of the pixel besides its depth.
  void Judge(const render::RayHit& hit,
             const Eigen::Vector3d& p_world,
             int u,
             int v,
             SensedView& sensed) const {
    const std::optional<std::size_t> o = ObjectOf(hit);
    if (!o) return;
    const PlacedObject& object = world.objects[*o];
    if (hit.face < object.shiny.size()) sensed.shiny(u, v) = object.shiny[hit.face];
    if (tops[*o] && std::abs(hit.normal_world.z()) > 0.5f &&
        tops[*o]->Inside(object_from_world[*o] * p_world, world.description.faults.table_edges_m)) {
      sensed.blind(u, v) = 1;
    }
  }

  [[nodiscard]] Image<Eigen::Vector3f> Shade(SensedView& sensed, const Pose3& pose) const;
};

// The picture; fills what `sensed` lacks on the way.
Image<Eigen::Vector3f> CaptureRenderer::Impl::Shade(SensedView& sensed, const Pose3& pose) const {
  const PinholeCamera& camera = world.description.camera;
  const Image<float> light = SurfaceLight(scene, sensed.view, world.description, camera, pose);
  sensed.reflectance = Image<float>(camera.width, camera.height, 0.0f);
  sensed.shiny = Mask(camera.width, camera.height, 0);
  sensed.blind = Mask(camera.width, camera.height, 0);
  Image<Eigen::Vector3f> radiance(camera.width, camera.height, kOutside);
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < camera.width; ++u) {
      const render::RayHit& hit = sensed.view.hits(u, v);
      if (hit.instance < 0) continue;
      const auto depth_m = static_cast<double>(sensed.view.depth_m(u, v));
      const Eigen::Vector3d p_world = pose * camera.Unproject(u, v, depth_m);
      const Eigen::Vector3f reflectance = Reflectance(hit, p_world, depth_m / camera.fx);
      radiance(u, v) = light(u, v) * reflectance;
      sensed.reflectance(u, v) = reflectance.mean();
      Judge(hit, p_world, u, v, sensed);
    }
  });
  return radiance;
}

CaptureRenderer::CaptureRenderer(World world) : impl_(std::make_unique<Impl>(std::move(world))) {}
CaptureRenderer::~CaptureRenderer() = default;
CaptureRenderer::CaptureRenderer(CaptureRenderer&&) noexcept = default;

int CaptureRenderer::num_frames() const { return static_cast<int>(impl_->kept.size()); }

const World& CaptureRenderer::world() const { return impl_->world; }

RenderedFrame CaptureRenderer::Render(int frame) const {
  DEEPSLAM_CHECK(frame >= 0 && frame < num_frames(), "frame outside the path");
  const SceneDescription& scene = impl_->world.description;
  const int on_path = impl_->kept[static_cast<std::size_t>(frame)];
  const auto at = [&](int i) -> const Pose3& {
    return impl_->path[static_cast<std::size_t>(
        std::clamp(i, 0, static_cast<int>(impl_->path.size()) - 1))];
  };
  const Pose3& pose = at(on_path);
  SensedView sensed{render::RenderView(impl_->scene, scene.camera, pose), {}, {}, {}};
  const FrameSeed seed{scene.seed, static_cast<std::uint64_t>(on_path)};

  RenderedFrame rendered;
  rendered.world_from_camera = pose;
  rendered.true_depth_m = sensed.view.depth_m;
  rendered.instances = Image<std::uint8_t>(scene.camera.width, scene.camera.height, 0);
  for (int v = 0; v < scene.camera.height; ++v) {
    for (int u = 0; u < scene.camera.width; ++u) {
      if (const std::optional<std::size_t> object = impl_->ObjectOf(sensed.view.hits(u, v)))
        rendered.instances(u, v) = static_cast<std::uint8_t>(*object + 1);
    }
  }
  rendered.frame.idx = FrameIdx{frame};
  rendered.frame.time_s = on_path / scene.frames_per_s;
  Image<Eigen::Vector3f> radiance = impl_->Shade(sensed, pose);
  if (scene.faults.exposure_time_s > 0) {
    // The way between the frames before and after, scaled to the time the shutter is open.
    const Vector6d way = T2v(at(on_path - 1).Inverse() * at(on_path + 1));
    const double half_open = 0.25 * scene.faults.exposure_time_s * scene.frames_per_s;
    radiance = MotionBlurred(
        radiance, rendered.true_depth_m, scene.camera, V2t(half_open * way), V2t(-half_open * way));
  }
  rendered.frame.colour =
      DevelopColour(radiance, scene.faults, ExposureGain(scene, rendered.frame.time_s), seed);
  rendered.frame.depth_m = ApplyDepthFaults(sensed, scene.camera, pose, scene, seed);
  return rendered;
}

}  // namespace deepslam::synth
