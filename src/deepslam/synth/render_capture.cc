#include "deepslam/synth/render_capture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/render/ray_scene.h"
#include "deepslam/render/render_view.h"
#include "deepslam/synth/camera_path.h"
#include "deepslam/synth/sensor_faults.h"
#include "deepslam/synth/surface_pattern.h"

namespace deepslam::synth {
namespace {

constexpr float kOffSurfaceM = 2e-3f;
// Things further away than this do not darken a corner.
constexpr float kAmbientReachM = 1.2f;
// Surfaces of the room are painted as finely as a pixel sees them from here.
constexpr double kPaintedFromM = 1.5;
// Each pixel casts one ray of a 4 x 4 pattern per light; the pattern's mean over a window is a soft
// shadow.
constexpr int kPattern = 4;

// A flat part's colours, painted once, at halving resolutions so that distant pixels see means and
// not noise.
class PaintedPart {
 public:
  PaintedPart(const RoomPart& part, const SceneDescription& scene) : part_(&part) {
    texel_m_ = kPaintedFromM / scene.camera.fx;
    const Eigen::Vector2i size = (part.extent_m / texel_m_).array().ceil().cast<int>().max(1);
    Image<Eigen::Vector3f> image(size.x(), size.y(), Eigen::Vector3f::Zero());
    ParallelFor(static_cast<std::size_t>(size.y()), [&](std::size_t row) {
      for (int u = 0; u < size.x(); ++u) {
        const Eigen::Vector2d p_m =
            texel_m_ * Eigen::Vector2d(u + 0.5, static_cast<double>(row) + 0.5);
        image(u, static_cast<int>(row)) = Paint(part, scene, p_m);
      }
    });
    levels_.push_back(std::move(image));
    while (levels_.back().width() > 1 && levels_.back().height() > 1)
      levels_.push_back(Halved(levels_.back()));
  }

  // `footprint_m`: what a pixel covers there.
  [[nodiscard]] Eigen::Vector3f At(const Eigen::Vector3d& p_world, double footprint_m) const {
    const Eigen::Vector3d d = p_world - part_->origin;
    const double level = std::log2(std::max(1.0, footprint_m / texel_m_));
    const std::size_t l =
        std::min(static_cast<std::size_t>(std::lround(level)), levels_.size() - 1);
    const Image<Eigen::Vector3f>& image = levels_[l];
    const double texel_m = texel_m_ * static_cast<double>(std::size_t{1} << l);
    const double x = std::clamp(d.dot(part_->u_axis) / texel_m - 0.5, 0.0, image.width() - 1.0);
    const double y = std::clamp(d.dot(part_->v_axis) / texel_m - 0.5, 0.0, image.height() - 1.0);
    const int u = std::min(static_cast<int>(x), std::max(0, image.width() - 2));
    const int v = std::min(static_cast<int>(y), std::max(0, image.height() - 2));
    const int u1 = std::min(u + 1, image.width() - 1);
    const int v1 = std::min(v + 1, image.height() - 1);
    const auto s = static_cast<float>(x - u);
    const auto t = static_cast<float>(y - v);
    return (1 - t) * ((1 - s) * image(u, v) + s * image(u1, v)) +
           t * ((1 - s) * image(u, v1) + s * image(u1, v1));
  }

 private:
  static Eigen::Vector3f Paint(const RoomPart& part,
                               const SceneDescription& scene,
                               const Eigen::Vector2d& p_m) {
    const std::uint64_t seed = scene.seed * 64 + static_cast<std::uint64_t>(part.number);
    switch (part.surface) {
      case RoomSurface::kFloor:
        return FloorColour(scene.floor, p_m, seed);
      case RoomSurface::kWall:
        return WallColour(scene.wall_colour, p_m, seed);
      case RoomSurface::kPoster:
        return PosterColour(part.number, p_m, part.extent_m, scene.seed);
      case RoomSurface::kCeiling:
        break;
    }
    return Eigen::Vector3f::Constant(0.75f);
  }

  static Image<Eigen::Vector3f> Halved(const Image<Eigen::Vector3f>& from) {
    Image<Eigen::Vector3f> to(from.width() / 2, from.height() / 2, Eigen::Vector3f::Zero());
    for (int v = 0; v < to.height(); ++v) {
      for (int u = 0; u < to.width(); ++u) {
        to(u, v) = 0.25f * (from(2 * u, 2 * v) + from(2 * u + 1, 2 * v) + from(2 * u, 2 * v + 1) +
                            from(2 * u + 1, 2 * v + 1));
      }
    }
    return to;
  }

  const RoomPart* part_;
  double texel_m_ = 0;
  std::vector<Image<Eigen::Vector3f>> levels_;
};

// Two unit vectors that complete n.
std::pair<Eigen::Vector3f, Eigen::Vector3f> Tangents(const Eigen::Vector3f& n) {
  const Eigen::Vector3f a =
      std::abs(n.x()) > 0.7f ? Eigen::Vector3f::UnitY() : Eigen::Vector3f::UnitX();
  const Eigen::Vector3f t = n.cross(a).normalized();
  return {t, n.cross(t)};
}

// Place in the 4 x 4 pattern; neighbours take far apart strata. No jitter: what varies from window
// to window is noise.
Eigen::Vector2d Stratum(int u, int v) {
  constexpr std::array<int, 16> kOrder = {0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
  const int cell = kOrder[static_cast<std::size_t>((v % kPattern) * kPattern + u % kPattern)];
  return Eigen::Vector2d(cell % kPattern + 0.5, cell / kPattern + 0.5) / kPattern;
}

}  // namespace

struct CaptureRenderer::Impl {
  World world;
  render::RayScene scene;
  std::vector<PaintedPart> painted;
  std::vector<Pose3> path;
  std::vector<std::vector<Eigen::Vector3f>> object_colours;  // linear, per vertex

  explicit Impl(World the_world)
      : world(std::move(the_world)), path(CameraPath(world.description)) {
    for (const RoomPart& part : world.room) {
      const Result<int> added = scene.AddMesh(part.mesh, Pose3());
      DEEPSLAM_CHECK(added.ok(), "a room's rectangle is a mesh");
      painted.emplace_back(part, world.description);
    }
    for (const PlacedObject& object : world.objects) {
      const Result<int> added = scene.AddMesh(object.mesh, object.world_from_object);
      DEEPSLAM_CHECK(added.ok(), "BuildWorld checks the models");
      std::vector<Eigen::Vector3f> colours;
      for (const Rgb8& colour : object.mesh.colours) colours.push_back(Linear(colour));
      colours.resize(object.mesh.vertices.size(), Linear({180, 180, 180}));
      object_colours.push_back(std::move(colours));
    }
    scene.Commit();
  }

  [[nodiscard]] int NumRoomParts() const { return static_cast<int>(world.room.size()); }
  [[nodiscard]] int NumTerms() const {
    return static_cast<int>(world.description.lights.size()) + 1;
  }

  [[nodiscard]] Eigen::Vector3f Reflectance(const render::RayHit& hit,
                                            const Eigen::Vector3d& p_world,
                                            double footprint_m) const {
    if (hit.instance < NumRoomParts())
      return painted[static_cast<std::size_t>(hit.instance)].At(p_world, footprint_m);
    const auto o = static_cast<std::size_t>(hit.instance - NumRoomParts());
    const PlacedObject& object = world.objects[o];
    const std::array<std::uint32_t, 3>& face = object.mesh.faces[hit.face];
    const std::vector<Eigen::Vector3f>& colours = object_colours[o];
    const Eigen::Vector3f base = (1 - hit.weight_b - hit.weight_c) * colours[face[0]] +
                                 hit.weight_b * colours[face[1]] + hit.weight_c * colours[face[2]];
    // Nothing real is of one colour only: a faint grain, coarser than a pixel.
    const Eigen::Vector3d p_object = object.world_from_object.Inverse() * p_world;
    const double grain = 0.06 * SmoothNoise(p_object / 0.02, world.description.seed + o) +
                         0.05 * SmoothNoise(p_object / 0.15, world.description.seed + o + 100);
    return (base * static_cast<float>(1 + grain)).cwiseMax(0.0f).cwiseMin(1.0f);
  }

  // One sample of each light and of the surroundings; `terms` has NumTerms() entries.
  void SampleLight(
      const Eigen::Vector3f& p, const Eigen::Vector3f& n, int u, int v, float* terms) const {
    const Eigen::Vector3f from = p + kOffSurfaceM * n;
    for (std::size_t l = 0; l < world.description.lights.size(); ++l) {
      const SceneLight& light = world.description.lights[l];
      const Eigen::Vector2d s = (Stratum(u, v).array() - 0.5) * light.side_m;
      const Eigen::Vector3f q = (light.position_m + Eigen::Vector3d(s.x(), s.y(), 0)).cast<float>();
      const Eigen::Vector3f way = q - from;
      const float distance = way.norm();
      const float cos_surface = n.dot(way) / distance;
      const float cos_light = way.z() / distance;
      terms[l] = 0;
      if (cos_surface <= 0 || cos_light <= 0 || scene.Occluded(from, q)) continue;
      terms[l] = static_cast<float>(light.power) * cos_surface * cos_light / (distance * distance);
    }
    const Eigen::Vector2d s = Stratum(u, v);
    const double r = std::sqrt(s.x());
    const double angle = 2 * std::numbers::pi * s.y();
    const auto [t, b] = Tangents(n);
    const Eigen::Vector3f direction = static_cast<float>(r * std::cos(angle)) * t +
                                      static_cast<float>(r * std::sin(angle)) * b +
                                      static_cast<float>(std::sqrt(1 - s.x())) * n;
    // The nearer a thing, the darker: a step at the reach would show as bands.
    const std::optional<render::RayHit> near = scene.Cast(from, direction, 0.0f, kAmbientReachM);
    const double open = near ? near->distance_m / static_cast<double>(kAmbientReachM) : 1.0;
    terms[world.description.lights.size()] = static_cast<float>(open * world.description.ambient);
  }

  [[nodiscard]] Image<float> Light(const render::RenderedView& view,
                                   const PinholeCamera& camera,
                                   const Pose3& pose) const;
  [[nodiscard]] Image<Eigen::Vector3f> Shade(const render::RenderedView& view,
                                             const PinholeCamera& camera,
                                             const Pose3& pose) const;
};

// Sum of all light per pixel, one sample each.
Image<float> CaptureRenderer::Impl::Light(const render::RenderedView& view,
                                          const PinholeCamera& camera,
                                          const Pose3& pose) const {
  Image<float> light(camera.width, camera.height, 0.0f);
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    std::vector<float> terms(static_cast<std::size_t>(NumTerms()), 0.0f);
    for (int u = 0; u < camera.width; ++u) {
      const render::RayHit& hit = view.hits(u, v);
      if (hit.instance < 0) continue;
      const Eigen::Vector3d p_world =
          pose * camera.Unproject(u, v, static_cast<double>(view.depth_m(u, v)));
      SampleLight(p_world.cast<float>(), hit.normal_world, u, v, terms.data());
      for (const float term : terms) light(u, v) += term;
    }
  });
  return light;
}

Image<Eigen::Vector3f> CaptureRenderer::Impl::Shade(const render::RenderedView& view,
                                                    const PinholeCamera& camera,
                                                    const Pose3& pose) const {
  const Image<float> light = Light(view, camera, pose);
  Image<Eigen::Vector3f> radiance(camera.width, camera.height, Eigen::Vector3f::Zero());
  ParallelFor(static_cast<std::size_t>(camera.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < camera.width; ++u) {
      const render::RayHit& hit = view.hits(u, v);
      if (hit.instance < 0) continue;
      // The window that holds every stratum once; only pixels of the same surface count.
      float sum = 0;
      int count = 0;
      for (int dv = -1; dv < kPattern - 1; ++dv) {
        for (int du = -1; du < kPattern - 1; ++du) {
          if (!view.hits.Contains(u + du, v + dv)) continue;
          const render::RayHit& other = view.hits(u + du, v + dv);
          if (other.instance != hit.instance || other.normal_world.dot(hit.normal_world) < 0.9f)
            continue;
          sum += light(u + du, v + dv);
          ++count;
        }
      }
      const double depth_m = static_cast<double>(view.depth_m(u, v));
      const Eigen::Vector3d p_world = pose * camera.Unproject(u, v, depth_m);
      radiance(u, v) =
          (sum / static_cast<float>(count)) * Reflectance(hit, p_world, depth_m / camera.fx);
    }
  });
  return radiance;
}

CaptureRenderer::CaptureRenderer(World world) : impl_(std::make_unique<Impl>(std::move(world))) {}
CaptureRenderer::~CaptureRenderer() = default;
CaptureRenderer::CaptureRenderer(CaptureRenderer&&) noexcept = default;

int CaptureRenderer::num_frames() const { return static_cast<int>(impl_->path.size()); }

const World& CaptureRenderer::world() const { return impl_->world; }

RenderedFrame CaptureRenderer::Render(int frame) const {
  DEEPSLAM_CHECK(frame >= 0 && frame < num_frames(), "frame outside the path");
  const SceneDescription& scene = impl_->world.description;
  const Pose3& pose = impl_->path[static_cast<std::size_t>(frame)];
  const render::RenderedView view = render::RenderView(impl_->scene, scene.camera, pose);
  const auto item = static_cast<std::uint64_t>(frame);

  RenderedFrame rendered;
  rendered.world_from_camera = pose;
  rendered.true_depth_m = view.depth_m;
  rendered.instances = Image<std::uint8_t>(scene.camera.width, scene.camera.height, 0);
  for (int v = 0; v < scene.camera.height; ++v) {
    for (int u = 0; u < scene.camera.width; ++u) {
      const int object = view.hits(u, v).instance - impl_->NumRoomParts();
      if (object >= 0)
        rendered.instances(u, v) = static_cast<std::uint8_t>(std::min(object + 1, 255));
    }
  }
  rendered.frame.idx = FrameIdx{frame};
  rendered.frame.time_s = frame / scene.frames_per_s;
  rendered.frame.colour =
      DevelopColour(impl_->Shade(view, scene.camera, pose), scene.faults, scene.seed, item);
  rendered.frame.depth_m =
      ApplyDepthFaults(view, scene.camera, pose, scene.faults, scene.seed, item);
  return rendered;
}

}  // namespace deepslam::synth
