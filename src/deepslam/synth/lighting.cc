#include "deepslam/synth/lighting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "deepslam/core/parallel.h"

namespace deepslam::synth {
namespace {

constexpr float kOffSurfaceM = 2e-3f;  // of where rays begin: no surface shadows itself
// Things further away than this do not darken a corner.
constexpr float kAmbientReachM = 1.2f;
constexpr int kPattern = 4;  // strata a side, one a pixel
constexpr int kStride = 2;  // px between samples
// Fewer samples than this on one surface, as on a chair's leg: more are cast there.
constexpr int kFewSamples = 6;
constexpr float kSameSurfaceCosine = 0.9f;  // 26 degrees: samples are not shared across edges

// Two unit vectors that complete n.
std::pair<Eigen::Vector3f, Eigen::Vector3f> Tangents(const Eigen::Vector3f& n) {
  const Eigen::Vector3f a =
      std::abs(n.x()) > 0.7f ? Eigen::Vector3f::UnitY() : Eigen::Vector3f::UnitX();
  const Eigen::Vector3f t = n.cross(a).normalized();
  return {t, n.cross(t)};
}

// A place of the 4 x 4 pattern: on a lamp of unit side about its middle, and as a direction of even
// light about the z axis (Malley's method).
struct Stratum {
  Eigen::Vector2f on_lamp = Eigen::Vector2f::Zero();
  Eigen::Vector3f direction = Eigen::Vector3f::UnitZ();
};

// Neighbours take far apart strata. No jitter: what varies from window to window is noise.
const Stratum& StratumAt(int u, int v) {
  static const std::array<Stratum, kPattern * kPattern> kStrata = [] {
    constexpr std::array<int, 16> kOrder = {0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
    std::array<Stratum, kPattern * kPattern> strata;
    for (std::size_t i = 0; i < strata.size(); ++i) {
      const double x = (kOrder[i] % kPattern + 0.5) / kPattern;
      const double y = (kOrder[i] / kPattern + 0.5) / kPattern;
      strata[i].on_lamp = Eigen::Vector2d(x - 0.5, y - 0.5).cast<float>();
      const double angle = 2 * std::numbers::pi * y;
      strata[i].direction = Eigen::Vector3d(std::sqrt(x) * std::cos(angle),
                                            std::sqrt(x) * std::sin(angle),
                                            std::sqrt(1 - x))
                                .cast<float>();
    }
    return strata;
  }();
  return kStrata[static_cast<std::size_t>((v % kPattern) * kPattern + u % kPattern)];
}

bool SameSurface(const render::RayHit& a, const render::RayHit& b) {
  return a.instance == b.instance && a.normal_world.dot(b.normal_world) >= kSameSurfaceCosine;
}

class Lighting {
 public:
  Lighting(const render::RayScene& scene,
           const render::RenderedView& view,
           const SceneDescription& description,
           const PinholeCamera& camera,
           const Pose3& world_from_camera)
      : scene_(scene),
        view_(view),
        description_(description),
        camera_(camera),
        world_from_camera_(world_from_camera),
        num_terms_(description.lights.size() + 1),
        width_((camera.width + kStride - 1) / kStride),
        height_((camera.height + kStride - 1) / kStride),
        sampled_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * num_terms_,
                 0.0f),
        meaned_(sampled_) {}

  Image<float> Compute() {
    ForRows(height_, [&](int y) { SampleRow(y); });
    ForRows(height_, [&](int y) { MeanRow(y); });
    Image<float> light(camera_.width, camera_.height, 0.0f);
    ForRows(camera_.height, [&](int v) { LightRow(v, light); });
    return light;
  }

 private:
  template <typename Body>
  static void ForRows(int count, const Body& body) {
    ParallelFor(static_cast<std::size_t>(count),
                [&](std::size_t row) { body(static_cast<int>(row)); });
  }
  [[nodiscard]] const render::RayHit& HitAt(int x, int y) const {
    return view_.hits(x * kStride, y * kStride);
  }
  [[nodiscard]] std::size_t Offset(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
            static_cast<std::size_t>(x)) *
           num_terms_;
  }
  [[nodiscard]] Eigen::Vector3f PointAt(int u, int v) const {
    return (world_from_camera_ * camera_.Unproject(u, v, static_cast<double>(view_.depth_m(u, v))))
        .cast<float>();
  }

  // What point p sees of each lamp (0 or 1) and of the surroundings (0 .. 1), in one direction
  // each.
  void Sample(const Eigen::Vector3f& p,
              const Eigen::Vector3f& n,
              const Stratum& stratum,
              float* terms) const {
    const Eigen::Vector3f from = p + kOffSurfaceM * n;
    for (std::size_t l = 0; l < description_.lights.size(); ++l) {
      const SceneLight& light = description_.lights[l];
      const Eigen::Vector2f s = static_cast<float>(light.side_m) * stratum.on_lamp;
      const Eigen::Vector3f q = light.position_m.cast<float>() + Eigen::Vector3f(s.x(), s.y(), 0);
      const Eigen::Vector3f way = q - from;
      const bool dark = n.dot(way) <= 0 || way.z() <= 0 || scene_.Occluded(from, q);
      terms[l] = dark ? 0.0f : 1.0f;
    }
    const auto [t, b] = Tangents(n);
    const Eigen::Vector3f direction = stratum.direction.x() * t + stratum.direction.y() * b +
                                      stratum.direction.z() * n;
    // The nearer a thing, the darker: a step at the reach would show as bands.
    const std::optional<render::RayHit> near = scene_.Cast(from, direction, 0.0f, kAmbientReachM);
    terms[num_terms_ - 1] = near ? static_cast<float>(near->distance_m) / kAmbientReachM : 1.0f;
  }

  void SampleRow(int y) {
    for (int x = 0; x < width_; ++x) {
      const render::RayHit& hit = HitAt(x, y);
      if (hit.instance < 0) continue;
      Sample(PointAt(x * kStride, y * kStride),
             hit.normal_world,
             StratumAt(x, y),
             sampled_.data() + Offset(x, y));
    }
  }

  // Samples all over the pattern at one point.
  int SampleMore(const Eigen::Vector3f& p, const Eigen::Vector3f& n, float* sums) const {
    std::vector<float> terms(num_terms_, 0.0f);
    int count = 0;
    for (int k = 0; k < kPattern * kPattern; k += 2, ++count) {
      Sample(p, n, StratumAt(k % kPattern + (k / kPattern) % 2, k / kPattern), terms.data());
      for (std::size_t t = 0; t < num_terms_; ++t) sums[t] += terms[t];
    }
    return count;
  }

  void MeanRow(int y) {
    for (int x = 0; x < width_; ++x) {
      const render::RayHit& hit = HitAt(x, y);
      if (hit.instance < 0) continue;
      float* mean = meaned_.data() + Offset(x, y);
      int count = 0;
      // The window that holds every stratum once; only samples of the same surface count.
      for (int dy = -1; dy < kPattern - 1; ++dy) {
        for (int dx = -1; dx < kPattern - 1; ++dx) {
          if (x + dx < 0 || y + dy < 0 || x + dx >= width_ || y + dy >= height_) continue;
          if (!SameSurface(HitAt(x + dx, y + dy), hit)) continue;
          const float* terms = sampled_.data() + Offset(x + dx, y + dy);
          for (std::size_t t = 0; t < num_terms_; ++t) mean[t] += terms[t];
          ++count;
        }
      }
      if (count < kFewSamples)
        count += SampleMore(PointAt(x * kStride, y * kStride), hit.normal_world, mean);
      for (std::size_t t = 0; t < num_terms_; ++t) mean[t] /= static_cast<float>(count);
    }
  }

  void LightRow(int v, Image<float>& light) const {
    std::vector<float> seen(num_terms_);
    for (int u = 0; u < camera_.width; ++u) {
      const render::RayHit& hit = view_.hits(u, v);
      if (hit.instance < 0) continue;
      const Eigen::Vector3f p = PointAt(u, v);
      std::fill(seen.begin(), seen.end(), 0.0f);
      int count = 0;
      for (int k = 0; k < 4; ++k) {
        const int x = std::min(u / kStride + (k & 1) * (u % kStride), width_ - 1);
        const int y = std::min(v / kStride + (k >> 1) * (v % kStride), height_ - 1);
        if (!SameSurface(HitAt(x, y), hit)) continue;
        const float* mean = meaned_.data() + Offset(x, y);
        for (std::size_t t = 0; t < num_terms_; ++t) seen[t] += mean[t];
        ++count;
      }
      if (count == 0) count = SampleMore(p, hit.normal_world, seen.data());
      const float share = 1.0f / static_cast<float>(count);
      float sum = share * seen[num_terms_ - 1] * static_cast<float>(description_.ambient);
      for (std::size_t l = 0; l + 1 < num_terms_; ++l)
        sum += share * seen[l] * Arriving(description_.lights[l], p, hit.normal_world);
      light(u, v) = sum;
    }
  }

  static float Arriving(const SceneLight& light,
                        const Eigen::Vector3f& p,
                        const Eigen::Vector3f& n) {
    const Eigen::Vector3f way = light.position_m.cast<float>() - p;
    const float square = std::max(1e-4f, way.squaredNorm());
    return static_cast<float>(light.power) * std::max(0.0f, n.dot(way)) * std::max(0.0f, way.z()) /
           (square * square);
  }

  const render::RayScene& scene_;
  const render::RenderedView& view_;
  const SceneDescription& description_;
  const PinholeCamera& camera_;
  const Pose3& world_from_camera_;
  std::size_t num_terms_;
  int width_;
  int height_;
  std::vector<float> sampled_;  // terms of each sample
  std::vector<float> meaned_;
};

}  // namespace

Image<float> SurfaceLight(const render::RayScene& scene,
                          const render::RenderedView& view,
                          const SceneDescription& description,
                          const PinholeCamera& camera,
                          const Pose3& world_from_camera) {
  return Lighting(scene, view, description, camera, world_from_camera).Compute();
}

}  // namespace deepslam::synth
