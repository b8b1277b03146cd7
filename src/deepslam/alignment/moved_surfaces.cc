#include "deepslam/alignment/moved_surfaces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "deepslam/alignment/alignment_levels.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/core/image.h"

namespace deepslam::alignment {
namespace {

// Seen through: this far behind, beside five standard deviations of the noise of the two.
constexpr float kMarginM = 0.05F;
constexpr float kMarginSigmas = 5.0F;
// Of a texel and its eight neighbours, so many have moved with it: outlines are off by a texel.
constexpr int kMinTogether = 7;
// Between neighbouring texels of one thing.
constexpr float kOneSurfaceM = 0.1F;
// Moved surfaces are hidden with their outlines, this many texels around.
constexpr int kOutline = 2;
// Share of the frame's depth that is worth a change.
constexpr double kMinShare = 0.02;

int CountAround(const Mask& mask, int u, int v, int radius) {
  int count = 0;
  for (int y = std::max(0, v - radius); y <= std::min(mask.height() - 1, v + radius); ++y) {
    for (int x = std::max(0, u - radius); x <= std::min(mask.width() - 1, u + radius); ++x)
      count += mask(x, y);
  }
  return count;
}

// Texels with at least `least` set ones within `radius`.
Mask Where(const Mask& mask, int radius, int least, bool of_set_only) {
  Mask result(mask.width(), mask.height());
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      const bool asked = mask(u, v) != 0 || !of_set_only;
      result(u, v) = asked && CountAround(mask, u, v, radius) >= least ? 1 : 0;
    }
  }
  return result;
}

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

// The coarsest that frames are aligned at: quick, and fine enough for an arm.
const PyramidLevel& LevelOf(const FramePyramid& pyramid) {
  return pyramid.levels[NumAlignmentLevels(pyramid) - 1];
}

// What an earlier frame says of the place where a surface stands now.
enum class Verdict { kNothing, kMoved, kStood };

class Witness {
 public:
  Witness(const PlacedPyramid& earlier, const PlacedPyramid& now, const DepthNoise& noise)
      : level_(LevelOf(*earlier.pyramid)),
        earlier_from_now_(earlier.world_from_camera.Inverse() * now.world_from_camera),
        noise_(noise.Scaled(std::max(earlier.pyramid->noise_scale, now.pyramid->noise_scale))) {}

  [[nodiscard]] Verdict Of(const Eigen::Vector3d& p_now) const {
    const Eigen::Vector3d p = earlier_from_now_ * p_now;
    const std::optional<float> seen_m = NearestAround(level_, p);
    if (!seen_m) return Verdict::kNothing;
    const float z_m = static_cast<float>(p.z());
    const float margin_m =
        kMarginM + kMarginSigmas * std::hypot(noise_.SigmaM(z_m), noise_.SigmaM(*seen_m));
    if (*seen_m < z_m - margin_m) return Verdict::kNothing;  // hidden from there
    return *seen_m > z_m + margin_m ? Verdict::kMoved : Verdict::kStood;
  }

 private:
  const PyramidLevel& level_;
  const Pose3 earlier_from_now_;
  const DepthNoise noise_;
};

struct Testimony {
  Mask seen_through;
  Mask told;  // texels that any witness says something of
};

Testimony TestimonyOn(const PlacedPyramid& frame,
                      std::span<const PlacedPyramid> earlier,
                      const DepthNoise& noise) {
  const PyramidLevel& level = LevelOf(*frame.pyramid);
  std::vector<Witness> latest_first;
  for (auto seen = earlier.rbegin(); seen != earlier.rend(); ++seen)
    latest_first.emplace_back(*seen, frame, noise);
  Mask mask(level.camera.width, level.camera.height);
  Mask told = mask;
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      const float z_m = level.depth_m[static_cast<std::size_t>(v * mask.width() + u)];
      if (!(z_m > 0)) continue;
      const Eigen::Vector3d p = static_cast<double>(z_m) * level.camera.Ray(u, v);
      Verdict verdict = Verdict::kNothing;
      for (std::size_t n = 0; n < latest_first.size() && verdict == Verdict::kNothing; ++n)
        verdict = latest_first[n].Of(p);
      mask(u, v) = verdict == Verdict::kMoved ? 1 : 0;
      told(u, v) = verdict == Verdict::kNothing ? 0 : 1;
    }
  }
  return {std::move(mask), std::move(told)};
}

double ShareSeenThrough(std::span<const PlacedPyramid> frames,
                        std::span<const PlacedPyramid> witnesses,
                        const DepthNoise& noise) {
  std::ptrdiff_t num_seen_through = 0;
  std::ptrdiff_t num_told = 0;
  for (const PlacedPyramid& frame : frames) {
    for (const PlacedPyramid& witness : witnesses) {
      const Testimony testimony = TestimonyOn(frame, {&witness, 1}, noise);
      num_seen_through += std::ranges::count(testimony.seen_through, std::uint8_t{1});
      num_told += std::ranges::count(testimony.told, std::uint8_t{1});
    }
  }
  return num_told > 0 ? static_cast<double>(num_seen_through) / static_cast<double>(num_told) : 0;
}

// What nobody tells anything of moves with what it hangs together with: a sleeve that no earlier
// frame had in view.
Mask WithWhatHangsOn(Mask moved, const Mask& told, const PyramidLevel& level) {
  std::vector<std::pair<int, int>> front;
  for (int v = 0; v < moved.height(); ++v) {
    for (int u = 0; u < moved.width(); ++u) {
      if (moved(u, v) != 0) front.emplace_back(u, v);
    }
  }
  const auto depth_m = [&](int u, int v) {
    return level.depth_m[static_cast<std::size_t>(v * level.camera.width + u)];
  };
  while (!front.empty()) {
    const auto [u, v] = front.back();
    front.pop_back();
    for (const auto& [x, y] : {std::pair(u - 1, v), {u + 1, v}, {u, v - 1}, {u, v + 1}}) {
      if (x < 0 || y < 0 || x >= moved.width() || y >= moved.height()) continue;
      if (moved(x, y) != 0 || told(x, y) != 0 || !(depth_m(x, y) > 0)) continue;
      if (std::abs(depth_m(x, y) - depth_m(u, v)) > kOneSurfaceM) continue;
      moved(x, y) = 1;
      front.emplace_back(x, y);
    }
  }
  return moved;
}

void Hide(const Mask& mask, PyramidLevel& level) {
  for (int v = 0; v < level.camera.height; ++v) {
    const int mask_v = std::min(mask.height() - 1, v * mask.height() / level.camera.height);
    for (int u = 0; u < level.camera.width; ++u) {
      const int mask_u = std::min(mask.width() - 1, u * mask.width() / level.camera.width);
      if (mask(mask_u, mask_v) == 0) continue;
      HidePixel(static_cast<std::size_t>(v * level.camera.width + u), level);
    }
  }
}

}  // namespace

std::shared_ptr<const FramePyramid> WithoutMoved(const PlacedPyramid& frame,
                                                 std::span<const PlacedPyramid> earlier,
                                                 const DepthNoise& noise) {
  const Testimony testimony = TestimonyOn(frame, earlier, noise);
  const Mask moved = WithWhatHangsOn(Where(testimony.seen_through, 1, kMinTogether, true),
                                     testimony.told,
                                     LevelOf(*frame.pyramid));
  const UnfilledVector<float>& depth_m = LevelOf(*frame.pyramid).depth_m;
  const auto num_valid = std::ranges::count_if(depth_m, [](float z) { return z > 0; });
  const auto num_moved = std::ranges::count(moved, std::uint8_t{1});
  if (static_cast<double>(num_moved) <= kMinShare * static_cast<double>(num_valid))
    return frame.pyramid;
  auto hidden = std::make_shared<FramePyramid>(*frame.pyramid);
  const Mask outlined = Where(moved, kOutline, 1, false);
  for (PyramidLevel& level : hidden->levels) Hide(outlined, level);
  return hidden;
}

double ContradictedShare(std::span<const PlacedPyramid> a,
                         std::span<const PlacedPyramid> b,
                         const DepthNoise& noise) {
  return std::max(ShareSeenThrough(a, b, noise), ShareSeenThrough(b, a, noise));
}

}  // namespace deepslam::alignment
