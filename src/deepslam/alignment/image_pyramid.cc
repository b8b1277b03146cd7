#include "deepslam/alignment/image_pyramid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <type_traits>
#include <utility>

#include <Eigen/Geometry>

#include "deepslam/alignment/texel_rows.h"
#include "deepslam/core/check.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/scene/brightness.h"

namespace deepslam::alignment {
namespace {

constexpr int kWindowRadius = 2;
// Noise is measured between 1 and this many times the model's: beyond, depth says nothing.
constexpr double kMaxNoiseScale = 8.0;
// Beyond the window of the last smoothing; noise that matching shares between neighbours is seen at
// this lag. Up to the second value it may as well be the scene's own relief.
constexpr int kFarLag = 2 * kWindowRadius + 1;
constexpr double kSureNoiseScale = 1.5;
// The median over every seventh texel of every seventh row is as good as that over all.
constexpr int kNoiseStride = 7;
// Fewer second differences say nothing about the noise.
constexpr std::size_t kMinDifferences = 100;
constexpr float kMadToSigma = 1.4826F;
// Levels smaller than this hold too little to align.
constexpr int kMinLevelWidth = 16;
constexpr int kMaxReduction = 32;
constexpr int kValidStride = 12;
// Columns looked at for whether there is but one depth; one part in so many may stray at either
// end.
constexpr int kOneDepthColumns = 40;
constexpr std::size_t kOneDepthStrays = 50;

std::size_t Offset(const PinholeCamera& camera, int u, int v) {
  return static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) +
         static_cast<std::size_t>(u);
}

std::size_t NumTexels(const PinholeCamera& camera) { return Offset(camera, 0, camera.height); }

// Depths of texels of a row and of their neighbours `lag` apart, one array for each.
struct SampledRow {
  explicit SampledRow(std::size_t most)
      : centre(most), left(most), right(most), up(most), down(most) {}
  std::size_t size = 0;
  std::vector<float> centre, left, right, up, down;

  void Take(const float* row, int width, int lag, int stride) {
    const std::ptrdiff_t to_below = static_cast<std::ptrdiff_t>(lag) * width;
    std::size_t n = 0;
    for (int u = lag; u + lag < width; u += stride, ++n) {
      centre[n] = row[u];
      left[n] = row[u - lag];
      right[n] = row[u + lag];
      up[n] = row[u - to_below];
      down[n] = row[u + to_below];
    }
    size = n;
  }
};

// Second differences of the inverse depth vanish on planes, however oblique. Times z^2 they are
// those of the depth, 2.45 = sqrt(1 + 1 + 4) times as wide as its noise. Negative where the noise
// cannot be told.
void Differences(const SampledRow& row,
                 const std::vector<float>& before,
                 const std::vector<float>& after,
                 const DepthNoise& noise,
                 float* differences) {
#pragma GCC ivdep
  for (std::size_t n = 0; n < row.size; ++n) {
    const float z = row.centre[n];
    const float inverse_sigma = 1.0F / (2.44948974F * noise.SigmaM(z));
    const float difference = z * (z / before[n] + z / after[n] - 2.0F);
    const float normalised = std::abs(difference) * inverse_sigma;
    const bool valid =
        (z > 0) & std::isfinite(z) & (before[n] > 0) & (after[n] > 0) & std::isfinite(normalised);
    differences[n] = valid ? normalised : -1.0F;
  }
}

// Whether the median of those that are not negative is at most `bound`, and how many these are.
struct MedianTest {
  std::size_t num_valid = 0;
  bool within = false;

  MedianTest(std::span<const float> values, float factor, float bound) {
    std::uint32_t valid = 0, num_within = 0;
    for (const float value : values) {
      valid += value >= 0 ? 1U : 0U;
      num_within += ((value >= 0) & (factor * value <= bound)) ? 1U : 0U;
    }
    num_valid = valid;
    within = num_within > valid / 2;
  }
};

// Deviation of the depth in units of `noise`, from texels `lag` apart: the median, so that half of
// the image may be edges. Noise shared over more than `lag` texels is not seen.
// `rows_about(v)`: row v, with `lag` rows before and behind it.
template <typename RowsAbout>
double NoiseScale(const RowsAbout& rows_about,
                  int width,
                  int height,
                  int lag,
                  int stride,
                  const DepthNoise& noise) {
  const std::size_t per_row = static_cast<std::size_t>(width / stride + 1);
  SampledRow row(per_row);
  std::vector<float> differences(2 * per_row * static_cast<std::size_t>(height / stride + 1));
  std::size_t size = 0;
  for (int v = lag; v + lag < height; v += stride) {
    row.Take(rows_about(v), width, lag, stride);
    Differences(row, row.left, row.right, noise, &differences[size]);
    Differences(row, row.up, row.down, noise, &differences[size + row.size]);
    size += 2 * row.size;
  }
  differences.resize(size);
  const MedianTest mostly(differences, kMadToSigma, 1.0F);
  // Mostly the median need not be known.
  if (mostly.num_valid < kMinDifferences || mostly.within) return 1.0;
  std::erase_if(differences, [](float difference) { return difference < 0; });
  return std::clamp(static_cast<double>(kMadToSigma * Median(differences)), 1.0, kMaxNoiseScale);
}

double NoiseScale(const PyramidLevel& level, int lag, const DepthNoise& noise) {
  const PinholeCamera& camera = level.camera;
  const auto rows_about = [&](int v) { return level.depth_m.data() + Offset(camera, 0, v); };
  return NoiseScale(rows_about, camera.width, camera.height, lag, kNoiseStride, noise);
}

double NoiseScale(const StoredDepth& depth, int stride, const DepthNoise& noise) {
  constexpr int kLag = 1;
  const int width = depth.width();
  std::vector<float> room;
  const auto rows_about = [&](int v) { return depth.Rows(v - kLag, 2 * kLag + 1, room) + width; };
  return NoiseScale(rows_about, width, depth.height(), kLag, stride, noise);
}

// Mean of the values that lie on the surface of the median one; 0 when there are none.
float BlockDepth(std::span<float> values, const DepthNoise& noise) {
  if (values.empty()) return 0;
  const auto [least, most] = std::ranges::minmax(values);
  // Mostly all are of one surface whichever the median is.
  if (most - least <= kSameSurfaceSigmas * noise.SigmaM(0.4F) + 0.01F * least) {
    return std::accumulate(values.begin(), values.end(), 0.0F) / static_cast<float>(values.size());
  }
  const float median = OrderStatistic(values, (values.size() - 1) / 2);
  const float tolerance = kSameSurfaceSigmas * noise.SigmaM(median) + 0.01F * median;
  float sum = 0;
  float count = 0;
  for (const float value : values) {
    const bool same = std::abs(value - median) <= tolerance;
    sum += same ? value : 0;
    count += same ? 1.0F : 0;
  }
  return sum / count;
}

// What BlockDepth makes of those of the four pixels from `upper` and `lower` on that are valid,
// without a branch: many at once. Below 0 where it depends on the order of summation, seldom.
float FourPixelDepth(const float* upper,
                     const float* lower,
                     float min_depth,
                     float max_depth,
                     float tolerance,
                     const DepthNoise& noise) {
  const auto lesser = [](float a, float b) { return a < b ? a : b; };
  const auto greater = [](float a, float b) { return a > b ? a : b; };
  const auto one = [](bool counts) { return counts ? 1.0F : 0.0F; };
  const auto valid = [&](float z) { return (z >= min_depth) & (z <= max_depth); };  // NaN: false
  const auto or_beyond = [&](float z) { return valid(z) ? z : std::numeric_limits<float>::max(); };
  const float a = or_beyond(upper[0]), b = or_beyond(upper[1]);
  const float c = or_beyond(lower[0]), d = or_beyond(lower[1]);
  const auto or_none = [&](float z) { return z <= max_depth ? z : 0.0F; };
  const float sum = or_none(a) + or_none(b) + or_none(c) + or_none(d);
  const float count =
      one(a <= max_depth) + one(b <= max_depth) + one(c <= max_depth) + one(d <= max_depth);
  // In their order, those that are not valid last.
  const float low_ab = lesser(a, b), high_ab = greater(a, b);
  const float low_cd = lesser(c, d), high_cd = greater(c, d);
  const float middle_a = greater(low_ab, low_cd), middle_b = lesser(high_ab, high_cd);
  const float first = lesser(low_ab, low_cd), second = lesser(middle_a, middle_b);
  const float third = greater(middle_a, middle_b), fourth = greater(high_ab, high_cd);
  const float most = greater(greater(or_none(a), or_none(b)), greater(or_none(c), or_none(d)));
  const bool one_surface = most - first <= tolerance + 0.01F * first;  // also where none is valid
  const float median = count > 2 ? second : first;
  const float near = kSameSurfaceSigmas * noise.SigmaM(median) + 0.01F * median;
  const auto same = [&](float z) { return std::abs(z - median) <= near; };
  const auto if_same = [&](float z) { return same(z) ? z : 0.0F; };
  const float sum_of_two = if_same(first) + if_same(second);
  const float sum_same = sum_of_two + if_same(third) + if_same(fourth);
  const bool in_any_order = sum_same == sum_of_two + if_same(fourth) + if_same(third);
  const float count_same =
      one(same(first)) + one(same(second)) + one(same(third)) + one(same(fourth));
  const float mean =
      (one_surface ? sum : sum_same) / (one_surface ? greater(count, 1) : count_same);
  return (one_surface | in_any_order) ? mean : -1.0F;
}

// Valid depths of a block of factor x factor pixels are gathered and reduced to one.
struct DepthReduction {
  DepthReduction(int by, const PyramidOptions& options, double noise_scale)
      : factor(by),
        min_depth(static_cast<float>(options.min_depth_m)),
        max_depth(static_cast<float>(options.max_depth_m)),
        noise(options.noise.Scaled(noise_scale)),
        tolerance(kSameSurfaceSigmas * noise.SigmaM(0.4F)),
        block(static_cast<std::size_t>(by * by)) {}

  // `size` blocks of the `factor` rows of pixels of which `depth` is the first one.
  void Reduce(const float* depth, int width, int size, float* out) {
    constexpr int kRun = 32;
    for (int begin = 0; begin < size; begin += kRun) {
      const int end = std::min(size, begin + kRun);
      if (factor == 2) {
        ReduceByTwo(depth, width, begin, end, out);
      } else {
        for (int u = begin; u < end; ++u) out[u] = OfBlock(depth + factor * u, width);
      }
    }
  }

 private:
  static bool AnyNegative(const float* numbers, int begin, int end) {
    int count = 0;
    for (int u = begin; u < end; ++u) count += numbers[u] < 0 ? 1 : 0;
    return count > 0;
  }

  void ReduceByTwo(const float* depth, int width, int begin, int end, float* out) {
    const float* const lower = depth + width;
#pragma GCC ivdep
    for (int u = begin; u < end; ++u)
      out[u] = FourPixelDepth(depth + 2 * u, lower + 2 * u, min_depth, max_depth, tolerance, noise);
    if (!AnyNegative(out, begin, end)) return;
    for (int u = begin; u < end; ++u) {
      if (out[u] < 0) out[u] = OfBlock(depth + 2 * u, width);
    }
  }
  [[nodiscard]] float OfBlock(const float* depth, int width) {
    std::size_t count = 0;
    for (int dv = 0; dv < factor; ++dv) {
      const float* const row = depth + static_cast<std::ptrdiff_t>(dv) * width;
      for (int du = 0; du < factor; ++du) {
        block[count] = row[du];
        const bool valid = (row[du] >= min_depth) & (row[du] <= max_depth);  // NaN: false
        count += valid ? 1 : 0;
      }
    }
    return BlockDepth({block.data(), count}, noise);
  }

  int factor;
  float min_depth, max_depth;
  DepthNoise noise;
  float tolerance;           // BlockDepth's
  std::vector<float> block;  // what is valid of it first
};

// `rows_from(v)`: `factor` rows from v on.
template <typename RowsFrom>
UnfilledVector<float> ReduceDepth(const RowsFrom& rows_from,
                                  int width,
                                  const PinholeCamera& reduced,
                                  int factor,
                                  const PyramidOptions& options,
                                  double noise_scale) {
  DepthReduction reduction(factor, options, noise_scale);
  UnfilledVector<float> result(NumTexels(reduced));
  for (int v = 0; v < reduced.height; ++v) {
    float* const out = result.data() + Offset(reduced, 0, v);
    reduction.Reduce(rows_from(v * factor), width, reduced.width, out);
  }
  return result;
}

// Weights of the taps of a window along one axis.
std::vector<float> TapWeights(int radius, float spread) {
  std::vector<float> weights;
  for (int d = -radius; d <= radius; ++d)
    weights.push_back(std::exp(-static_cast<float>(d * d) / spread));
  return weights;
}

int WindowRadius(double noise_scale) {
  return static_cast<int>(std::lround(kWindowRadius * std::sqrt(noise_scale)));
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
  constexpr std::size_t kMiddle = sizeof...(kTaps) / 2;
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

template <int kRadius = kWindowRadius>
void SmoothAcross(std::span<const float* const> taps,
                  std::span<const float> tap_weights,
                  const DepthNoise& noise,
                  int width,
                  float* out) {
  // What depth noise up to kMaxNoiseScale asks for.
  constexpr int kMostRadius = 6;
  constexpr std::size_t kNumTaps = 2 * kRadius + 1;
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
    std::copy_n(depth_.data() + Offset(camera_, 0, v), camera_.width, padded_.data() + radius_);
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

// Weighted mean over a window of what lies on the same surface (a bilateral filter with the depth
// noise as range), along rows and then along columns (Pham and van Vliet 2005). The slope of white
// noise smoothed over a window falls with the window's area, so an area in proportion to the noise
// keeps the normals as good as they are at scale 1.
UnfilledVector<float> SmoothDepth(const UnfilledVector<float>& depth,
                                  const PinholeCamera& camera,
                                  const DepthNoise& model,
                                  double noise_scale) {
  const DepthNoise noise = model.Scaled(noise_scale);
  const std::vector<float> tap_weights =
      TapWeights(WindowRadius(noise_scale), 4.5F * static_cast<float>(noise_scale));
  SmoothedRows rows(depth, camera, tap_weights, noise);
  UnfilledVector<float> result(depth.size());
  for (int v = 0; v < camera.height; ++v) {
    SmoothAcross(
        rows.Around(v), tap_weights, noise, camera.width, result.data() + Offset(camera, 0, v));
  }
  return result;
}

BrightnessImage Halved(const BrightnessImage& fine, const PinholeCamera& reduced) {
  BrightnessImage result(reduced.width, reduced.height);
  const std::ptrdiff_t width = fine.width();
  for (int v = 0; v < reduced.height; ++v) {
    const float* const upper = fine.data() + 2 * v * width;
    const float* const lower = upper + width;
    float* const out = result.data() + Offset(reduced, 0, v);
    for (int u = 0; u < reduced.width; ++u)
      out[u] = 0.25F * (upper[2 * u] + upper[2 * u + 1] + lower[2 * u] + lower[2 * u + 1]);
  }
  return result;
}

PyramidLevel FinestLevel(const StoredDepth& depth,
                         const PinholeCamera& camera,
                         const PyramidOptions& options) {
  const int factor = WorkReduction(camera, options);
  PyramidLevel level;
  level.camera = camera.Reduced(factor);
  const double raw_scale = NoiseScale(depth, kNoiseStride * factor, options.noise);
  std::vector<float> room;
  const auto rows_from = [&](int v) { return depth.Rows(v, factor, room); };
  level.depth_m = ReduceDepth(rows_from, camera.width, level.camera, factor, options, raw_scale);
  if (options.smooth_depth) {
    const double shared = NoiseScale(level, kFarLag, options.noise);
    const double scale =
        std::max(NoiseScale(level, 1, options.noise), shared > kSureNoiseScale ? shared : 1.0);
    // The range weights of a noisy texel favour its own error; a second pass takes what is left.
    if (scale > 1) {
      level.depth_m = SmoothDepth(level.depth_m, level.camera, options.noise, scale);
    }
    level.depth_m = SmoothDepth(level.depth_m, level.camera, options.noise, 1);
  }
  return level;
}

PyramidLevel Halved(const PyramidLevel& fine, const PyramidOptions& options, double noise_scale) {
  PyramidLevel level;
  level.camera = fine.camera.Reduced(2);
  const auto rows_from = [&](int v) { return fine.depth_m.data() + Offset(fine.camera, 0, v); };
  level.depth_m = ReduceDepth(rows_from, fine.camera.width, level.camera, 2, options, noise_scale);
  return level;
}

// Nothing where the finest level has another size.
void AddBrightness(BrightnessImage finest, std::vector<PyramidLevel>& levels) {
  const PinholeCamera& camera = levels.front().camera;
  if (finest.width() != camera.width || finest.height() != camera.height) return;
  levels.front().brightness = std::move(finest);
  for (std::size_t k = 1; k < levels.size(); ++k)
    levels[k].brightness = Halved(levels[k - 1].brightness, levels[k].camera);
}

// Told by some rows: those with a normal, of all their texels.
double ValidShare(const PyramidLevel& level) {
  SurfaceRow row(level.camera.width);
  const float* const offset_m = row[3];
  int num_valid = 0, num_texels = 0;
  for (int v = kValidStride / 2; v < level.camera.height; v += kValidStride) {
    ReadSurface(level, v, row);
    for (int u = 0; u < level.camera.width; ++u) num_valid += offset_m[u] < 0 ? 1 : 0;
    num_texels += level.camera.width;
  }
  return num_texels > 0 ? static_cast<double>(num_valid) / num_texels : 0;
}

// Of some hundred pixels, but for a few strays; without depth there is nothing to tell.
bool HasOneDepth(const StoredDepth& depth) {
  std::vector<float> samples;
  const int step = std::max(1, depth.width() / kOneDepthColumns);
  for (int v = step / 2; v < depth.height(); v += step) {
    for (int u = step / 2; u < depth.width(); u += step) {
      if (depth(u, v) > 0) samples.push_back(depth(u, v));
    }
  }
  if (samples.empty()) return false;
  const auto [low, high] = InnerRange(samples, kOneDepthStrays);
  return low == high;
}

}  // namespace

int WorkReduction(const PinholeCamera& camera, const PyramidOptions& options) {
  int factor = 1;
  while (camera.width / factor > options.work_width_px && factor < kMaxReduction) ++factor;
  return factor;
}

FramePyramid BuildPyramid(const Frame& frame,
                          const PinholeCamera& camera,
                          const PyramidOptions& options) {
  const bool fits = frame.colour.width() == camera.width && frame.colour.height() == camera.height;
  const int factor = WorkReduction(camera, options);
  BrightnessImage brightness = fits ? BrightnessOf(frame.colour, factor) : BrightnessImage();
  return BuildPyramid(StoredDepth(frame.depth_m), std::move(brightness), camera, options);
}

DEEPSLAM_WIDE_VECTORS FramePyramid BuildPyramid(const StoredDepth& depth,
                                                BrightnessImage brightness,
                                                const PinholeCamera& camera,
                                                const PyramidOptions& options) {
  if (depth.empty() || depth.width() != camera.width || depth.height() != camera.height) return {};
  FramePyramid pyramid;
  pyramid.one_depth = HasOneDepth(depth);
  pyramid.levels.push_back(FinestLevel(depth, camera, options));
  // Beyond the window, so that what smoothing shared between neighbours is seen.
  pyramid.noise_scale = NoiseScale(pyramid.levels.front(), kFarLag, options.noise);
  while (static_cast<int>(pyramid.levels.size()) < options.num_levels &&
         pyramid.levels.back().camera.width >= 2 * kMinLevelWidth &&
         pyramid.levels.back().camera.height >= 2 * kMinLevelWidth / 2) {
    pyramid.levels.push_back(Halved(pyramid.levels.back(), options, pyramid.noise_scale));
  }
  for (PyramidLevel& level : pyramid.levels)
    level.noise = options.noise.Scaled(pyramid.noise_scale);
  AddBrightness(std::move(brightness), pyramid.levels);
  pyramid.valid_share = ValidShare(pyramid.levels.front());
  return pyramid;
}

Result<ReadFrame> ReadPyramid(const FrameSource& frames,
                              FrameIdx frame,
                              const PyramidOptions& options) {
  const PinholeCamera& camera = frames.camera();
  Result<StoredDepth> depth = frames.ReadStoredDepth(frame);
  if (!depth.ok()) return depth.error();
  Result<BrightnessImage> brightness = frames.ReadBrightness(frame, WorkReduction(camera, options));
  if (!brightness.ok()) return brightness.error();
  FramePyramid pyramid = BuildPyramid(*depth, std::move(*brightness), camera, options);
  if (pyramid.empty()) return InvalidInput("depth image has not the size of the camera");
  return ReadFrame{std::move(pyramid), *std::move(depth)};
}

void Describe(OptionsVisitor& visitor, PyramidOptions& options) {
  visitor.Field("work_width_px",
                options.work_width_px,
                {32, 640},
                "px",
                "finest level: the capture reduced by a whole factor to at most this width");
  visitor.Field(
      "num_levels", options.num_levels, {1, 6}, "1", "levels of the pyramid, each half as wide");
  visitor.Field("min_depth_m", options.min_depth_m, {0.01, 10}, "m", "nearer depth is invalid");
  visitor.Field("max_depth_m", options.max_depth_m, {0.1, 100}, "m", "farther depth is invalid");
  visitor.Field("smooth_depth", options.smooth_depth, "edge-respecting smoothing of the depth");
  visitor.Field("noise_base_m",
                options.noise.base_m,
                {1e-5, 1},
                "m",
                "depth noise at 0.4 m, one standard deviation");
  visitor.Field("noise_growth_per_m",
                options.noise.growth_per_m,
                {0, 1},
                "1/m",
                "depth noise grows by this times the square of the depth beyond 0.4 m");
}

}  // namespace deepslam::alignment
