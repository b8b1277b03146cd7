#include "deepslam/odometry/moved_surfaces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace deepslam::odometry {
namespace {

// Coarse enough to be quick, fine enough for an arm.
constexpr int kMinWidth = 60;
// Seen through: this far behind, beside five standard deviations of the noise of the two.
constexpr float kMarginM = 0.05F;
constexpr float kMarginSigmas = 5.0F;
// Of a texel and its eight neighbours, so many have moved with it: outlines are off by a texel.
constexpr int kMinTogether = 7;
// Moved surfaces are hidden with their outlines, this many texels around.
constexpr int kOutline = 2;
// Share of the frame's depth that is worth a change.
constexpr double kMinShare = 0.02;

struct Mask {
  int width = 0, height = 0;
  std::vector<std::uint8_t> set;

  [[nodiscard]] int CountAround(int u, int v, int radius) const {
    int count = 0;
    for (int y = std::max(0, v - radius); y <= std::min(height - 1, v + radius); ++y) {
      for (int x = std::max(0, u - radius); x <= std::min(width - 1, u + radius); ++x)
        count += set[static_cast<std::size_t>(y * width + x)];
    }
    return count;
  }
  // Texels with at least `least` set ones within `radius`.
  [[nodiscard]] Mask Where(int radius, int least, bool of_set_only) const {
    Mask result = *this;
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const std::size_t k = static_cast<std::size_t>(v * width + u);
        result.set[k] = (set[k] != 0 || !of_set_only) && CountAround(u, v, radius) >= least;
      }
    }
    return result;
  }
};

// The nearest depth about the pixel where the point falls; nothing where the frame has none of it.
std::optional<float> NearestAround(const PyramidLevel& level, const Eigen::Vector3d& p_camera) {
  const std::optional<Eigen::Vector2d> pixel = level.camera.Project(p_camera);
  if (!pixel || (pixel->array() < 0.5).any() || pixel->x() > level.camera.width - 1.5 ||
      pixel->y() > level.camera.height - 1.5)
    return std::nullopt;
  const int u = static_cast<int>(pixel->x() + 0.5);
  const int v = static_cast<int>(pixel->y() + 0.5);
  float nearest_m = std::numeric_limits<float>::infinity();
  for (int y = v - 1; y <= v + 1; ++y) {
    for (int x = u - 1; x <= u + 1; ++x)
      nearest_m =
          std::min(nearest_m, level.depth_m[static_cast<std::size_t>(y * level.camera.width + x)]);
  }
  return nearest_m > 0 ? std::optional(nearest_m) : std::nullopt;
}

std::size_t CheckedLevel(const FramePyramid& pyramid) {
  std::size_t level = 0;
  while (level + 1 < pyramid.levels.size() && pyramid.levels[level + 1].camera.width >= kMinWidth)
    ++level;
  return level;
}

float MarginM(float near_m, float far_m, double noise_scale) {
  const DepthNoise noise = DepthNoise{}.Scaled(noise_scale);
  return kMarginM + kMarginSigmas * std::hypot(noise.SigmaM(near_m), noise.SigmaM(far_m));
}

Mask SeenThrough(const PlacedPyramid& frame, std::span<const PlacedPyramid> earlier) {
  const std::size_t at = CheckedLevel(*frame.pyramid);
  const PyramidLevel& level = frame.pyramid->levels[at];
  Mask mask{level.camera.width, level.camera.height, {}};
  mask.set.resize(level.depth_m.size());
  for (int v = 0; v < mask.height; ++v) {
    for (int u = 0; u < mask.width; ++u) {
      const std::size_t k = static_cast<std::size_t>(v * mask.width + u);
      const float depth_m = level.depth_m[k];
      if (!(depth_m > 0)) continue;
      const Eigen::Vector3d p_world =
          frame.world_from_camera * (static_cast<double>(depth_m) * level.camera.Ray(u, v));
      for (auto seen = earlier.rbegin(); seen != earlier.rend(); ++seen) {
        const Eigen::Vector3d p_seen = seen->world_from_camera.Inverse() * p_world;
        const std::optional<float> there_m = NearestAround(seen->pyramid->levels[at], p_seen);
        if (!there_m) continue;
        const float z_m = static_cast<float>(p_seen.z());
        const float margin_m = MarginM(
            z_m, *there_m, std::max(frame.pyramid->noise_scale, seen->pyramid->noise_scale));
        if (*there_m < z_m - margin_m) continue;  // hidden from there
        mask.set[k] = *there_m > z_m + margin_m;
        break;
      }
    }
  }
  return mask;
}

void Hide(const Mask& mask, PyramidLevel& level) {
  for (int v = 0; v < level.camera.height; ++v) {
    const int mask_v = std::min(mask.height - 1, v * mask.height / level.camera.height);
    for (int u = 0; u < level.camera.width; ++u) {
      const int mask_u = std::min(mask.width - 1, u * mask.width / level.camera.width);
      if (mask.set[static_cast<std::size_t>(mask_v * mask.width + mask_u)] == 0) continue;
      const std::size_t k = static_cast<std::size_t>(v * level.camera.width + u);
      level.depth_m[k] = 0;
      level.surface[k] = SurfaceTexel{};
    }
  }
}

}  // namespace

std::shared_ptr<const FramePyramid> WithoutMoved(const PlacedPyramid& frame,
                                                 std::span<const PlacedPyramid> earlier) {
  const Mask moved = SeenThrough(frame, earlier).Where(1, kMinTogether, true);
  const std::vector<float>& depth_m = frame.pyramid->levels[CheckedLevel(*frame.pyramid)].depth_m;
  const auto num_valid = std::ranges::count_if(depth_m, [](float z) { return z > 0; });
  const auto num_moved = std::ranges::count(moved.set, std::uint8_t{1});
  if (static_cast<double>(num_moved) <= kMinShare * static_cast<double>(num_valid))
    return frame.pyramid;
  auto hidden = std::make_shared<FramePyramid>(*frame.pyramid);
  const Mask outlined = moved.Where(kOutline, 1, false);
  for (PyramidLevel& level : hidden->levels) Hide(outlined, level);
  return hidden;
}

}  // namespace deepslam::odometry
