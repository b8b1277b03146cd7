#include "deepslam/alignment/depth_reduction.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::alignment {
namespace {

// Of the depth: a slope adds so much to what a block of one surface may differ by.
constexpr float kSlopeShare = 0.01F;
// Noise is least here, so that what differs by less is of one surface whatever its depth.
constexpr float kLeastNoiseDepthM = 0.4F;

// Mean of the values that lie on the surface of the median one; 0 when there are none.
float BlockDepth(std::span<float> values, const DepthNoise& noise) {
  if (values.empty()) return 0;
  const auto [least, most] = std::ranges::minmax(values);
  // Mostly all are of one surface whichever the median is.
  if (most - least <= kSameSurfaceSigmas * noise.SigmaM(kLeastNoiseDepthM) + kSlopeShare * least) {
    return std::accumulate(values.begin(), values.end(), 0.0F) / static_cast<float>(values.size());
  }
  const float median = OrderStatistic(values, (values.size() - 1) / 2);
  const float tolerance = kSameSurfaceSigmas * noise.SigmaM(median) + kSlopeShare * median;
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
  const bool one_surface =
      most - first <= tolerance + kSlopeShare * first;  // also where none is valid
  const float median = count > 2 ? second : first;
  const float near = kSameSurfaceSigmas * noise.SigmaM(median) + kSlopeShare * median;
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
class DepthReduction {
 public:
  DepthReduction(int by, const PyramidOptions& options, double noise_scale)
      : factor_(by),
        min_depth_(static_cast<float>(options.min_depth_m)),
        max_depth_(static_cast<float>(options.max_depth_m)),
        noise_(options.noise.Scaled(noise_scale)),
        tolerance_(kSameSurfaceSigmas * noise_.SigmaM(kLeastNoiseDepthM)),
        block_(static_cast<std::size_t>(by * by)) {}

  [[nodiscard]] int factor() const { return factor_; }

  // `size` blocks of the `factor` rows of pixels of which `depth` is the first one.
  void Reduce(const float* depth, int width, int size, float* out) {
    constexpr int kRun = 32;  // results a run, over which few of them need the slower median
    for (int begin = 0; begin < size; begin += kRun) {
      const int end = std::min(size, begin + kRun);
      if (factor_ == 2) {
        ReduceByTwo(depth, width, begin, end, out);
      } else {
        for (int u = begin; u < end; ++u) out[u] = OfBlock(depth + factor_ * u, width);
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
      out[u] =
          FourPixelDepth(depth + 2 * u, lower + 2 * u, min_depth_, max_depth_, tolerance_, noise_);
    if (!AnyNegative(out, begin, end)) return;
    for (int u = begin; u < end; ++u) {
      if (out[u] < 0) out[u] = OfBlock(depth + 2 * u, width);
    }
  }
  [[nodiscard]] float OfBlock(const float* depth, int width) {
    std::size_t count = 0;
    for (int dv = 0; dv < factor_; ++dv) {
      const float* const row = depth + static_cast<std::ptrdiff_t>(dv) * width;
      for (int du = 0; du < factor_; ++du) {
        block_[count] = row[du];
        const bool valid = (row[du] >= min_depth_) & (row[du] <= max_depth_);  // NaN: false
        count += valid ? 1 : 0;
      }
    }
    return BlockDepth({block_.data(), count}, noise_);
  }

  int factor_;
  float min_depth_, max_depth_;
  DepthNoise noise_;
  float tolerance_;           // BlockDepth's
  std::vector<float> block_;  // what is valid of it first
};

// `rows_from(v)`: as many rows from v on as the reduction takes together.
template <typename RowsFrom>
UnfilledVector<float> Reduced(const RowsFrom& rows_from,
                              int width,
                              const PinholeCamera& camera,
                              DepthReduction reduction) {
  UnfilledVector<float> result(static_cast<std::size_t>(camera.width) *
                               static_cast<std::size_t>(camera.height));
  for (int v = 0; v < camera.height; ++v) {
    float* const out = result.data() + static_cast<std::ptrdiff_t>(v) * camera.width;
    reduction.Reduce(rows_from(v * reduction.factor()), width, camera.width, out);
  }
  return result;
}

}  // namespace

DEEPSLAM_WIDE_VECTORS UnfilledVector<float> ReduceDepth(const StoredDepth& depth,
                                                        const PinholeCamera& reduced,
                                                        int factor,
                                                        const PyramidOptions& options,
                                                        double noise_scale) {
  std::vector<float> room;
  const auto rows_from = [&](int v) { return depth.Rows(v, factor, room); };
  return Reduced(rows_from, depth.width(), reduced, DepthReduction(factor, options, noise_scale));
}

DEEPSLAM_WIDE_VECTORS UnfilledVector<float> HalveDepth(const PyramidLevel& fine,
                                                       const PinholeCamera& reduced,
                                                       const PyramidOptions& options,
                                                       double noise_scale) {
  const int width = fine.camera.width;
  const auto rows_from = [&](int v) {
    return fine.depth_m.data() + static_cast<std::ptrdiff_t>(v) * width;
  };
  return Reduced(rows_from, width, reduced, DepthReduction(2, options, noise_scale));
}

}  // namespace deepslam::alignment
