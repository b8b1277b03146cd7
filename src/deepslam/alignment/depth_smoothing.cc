#include "deepslam/alignment/depth_smoothing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/core/check.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::alignment {
namespace {

// Weights of the taps of a window along one axis.
std::vector<float> TapWeights(int radius, float spread) {
  std::vector<float> weights;
  for (int d = -radius; d <= radius; ++d)
    weights.push_back(std::exp(-static_cast<float>(d * d) / spread));
  return weights;
}

int WindowRadius(double noise_scale) {
  return static_cast<int>(std::lround(kSmoothingRadius * std::sqrt(noise_scale)));
}

// Weighted mean, for every column u, of what lies on the surface of the middle one of
// `taps`[...][u].
template <std::size_t... kTaps>
void SmoothAcross(const float* const* taps,
                  const float* tap_weights,
                  const DepthNoise& noise,
                  int width,
                  float* out,
                  std::index_sequence<kTaps...> /*taps*/) {
  const std::array<const float*, sizeof...(kTaps)> rows = {taps[kTaps]...};
  const std::array<float, sizeof...(kTaps)> weights = {tap_weights[kTaps]...};
  constexpr std::size_t kMiddle = sizeof...(kTaps) / 2;  // the tap of the pixel itself
#pragma GCC ivdep
  for (int u = 0; u < width; ++u) {
    const float middle = rows[kMiddle][u];
    // The tolerance stays below the depth itself, so that invalid neighbours get no weight.
    const float tolerance =
        std::min(kSameSurfaceSigmas * noise.SigmaM(middle), 0.5F * middle + 1e-6F);
    const float inverse_sq = 1.0F / (tolerance * tolerance);
    float sum = 0, sum_weight = 1e-6F;
    const auto add = [&](float depth, float tap_weight) {
      const float difference = depth - middle;
      const float w = tap_weight * std::max(0.0F, 1.0F - difference * difference * inverse_sq);
      sum += w * difference;
      sum_weight += w;
    };
    const auto add_tap = [&]<std::size_t kTap>(std::integral_constant<std::size_t, kTap> /*tap*/) {
      if constexpr (kTap == kMiddle) {
        sum_weight += weights[kTap];  // it does not differ from itself
      } else {
        add(rows[kTap][u], weights[kTap]);
      }
    };
    (add_tap(std::integral_constant<std::size_t, kTaps>{}), ...);
    out[u] = middle > 0 ? middle + sum / sum_weight : 0.0F;
  }
}

template <int kRadius = kSmoothingRadius>
void SmoothAcross(std::span<const float* const> taps,
                  std::span<const float> tap_weights,
                  const DepthNoise& noise,
                  int width,
                  float* out) {
  // What depth noise up to kMaxNoiseScale asks for.
  constexpr int kMostRadius = 6;
  constexpr std::size_t kNumTaps = 2 * kRadius + 1;  // of a window: both sides and the middle
  if constexpr (kRadius < kMostRadius) {
    if (taps.size() != kNumTaps)
      return SmoothAcross<kRadius + 1>(taps, tap_weights, noise, width, out);
  }
  DEEPSLAM_CHECK(taps.size() == kNumTaps, "no such window");
  SmoothAcross(
      taps.data(), tap_weights.data(), noise, width, out, std::make_index_sequence<kNumTaps>());
}

// Rows smoothed along themselves, the last ones of a window; before the first and behind the last
// there is no depth.
class SmoothedRows {
 public:
  SmoothedRows(const UnfilledVector<float>& depth,
               const PinholeCamera& camera,
               std::span<const float> tap_weights,
               const DepthNoise& noise)
      : depth_(depth),
        camera_(camera),
        tap_weights_(tap_weights),
        noise_(noise),
        radius_(static_cast<int>(tap_weights.size() / 2)),
        padded_(static_cast<std::size_t>(camera.width + 2 * radius_)),
        rows_(tap_weights.size()),
        taps_(tap_weights.size()) {
    for (std::vector<float>& row : rows_) row.resize(static_cast<std::size_t>(camera.width));
    for (int v = 0; v < radius_; ++v) Make(v);
  }

  // The window's rows about row v, until the next call; v ascends by ones.
  std::span<const float* const> Around(int v) {
    Make(v + radius_);
    for (int d = -radius_; d <= radius_; ++d)
      taps_[static_cast<std::size_t>(d + radius_)] = Row(v + d).data();
    return taps_;
  }

 private:
  std::vector<float>& Row(int v) {
    const int num_rows = static_cast<int>(rows_.size());
    return rows_[static_cast<std::size_t>((v + num_rows) % num_rows)];
  }
  void Make(int v) {
    std::vector<float>& row = Row(v);
    if (v >= camera_.height) {
      std::ranges::fill(row, 0.0F);
      return;
    }
    std::copy_n(depth_.data() + static_cast<std::ptrdiff_t>(v) * camera_.width,
                camera_.width,
                padded_.data() + radius_);
    for (std::size_t k = 0; k < taps_.size(); ++k) taps_[k] = padded_.data() + k;
    SmoothAcross(taps_, tap_weights_, noise_, camera_.width, row.data());
  }

  const UnfilledVector<float>& depth_;
  const PinholeCamera& camera_;
  std::span<const float> tap_weights_;
  const DepthNoise& noise_;
  int radius_;
  std::vector<float> padded_;  // no depth before and behind: too far off to get weight
  std::vector<std::vector<float>> rows_;
  std::vector<const float*> taps_;
};

}  // namespace

DEEPSLAM_WIDE_VECTORS UnfilledVector<float> SmoothDepth(const UnfilledVector<float>& depth_m,
                                                        const PinholeCamera& camera,
                                                        const DepthNoise& model,
                                                        double noise_scale) {
  const DepthNoise noise = model.Scaled(noise_scale);
  const std::vector<float> tap_weights =
      TapWeights(WindowRadius(noise_scale), 4.5F * static_cast<float>(noise_scale));
  SmoothedRows rows(depth_m, camera, tap_weights, noise);
  UnfilledVector<float> result(depth_m.size());
  for (int v = 0; v < camera.height; ++v) {
    SmoothAcross(rows.Around(v),
                 tap_weights,
                 noise,
                 camera.width,
                 result.data() + static_cast<std::ptrdiff_t>(v) * camera.width);
  }
  return result;
}

}  // namespace deepslam::alignment
