#include "deepslam/frames/noise_scale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam {
namespace {

// Fewer second differences say nothing about the noise.
constexpr std::size_t kMinDifferences = 100;
constexpr float kMadToSigma = 1.4826F;  // of normally distributed differences

// Depths of pixels of a row and of their neighbours `lag` apart, one array for each.
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
// is not known.
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

// Deviation of the depth in units of `noise`, from pixels `lag` apart: the median, so that half of
// the image may be edges. Noise shared over more than `lag` pixels is not seen.
// `rows_about(v)`: row v, with `lag` rows before and behind it.
template <typename RowsAbout>
double NoiseScaleOfRows(const RowsAbout& rows_about,
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

}  // namespace

DEEPSLAM_WIDE_VECTORS double NoiseScaleOf(std::span<const float> depth_m,
                                          int width,
                                          int lag,
                                          const DepthNoise& noise) {
  const int height = width > 0 ? static_cast<int>(depth_m.size()) / width : 0;
  const auto rows_about = [&](int v) {
    return depth_m.data() + static_cast<std::ptrdiff_t>(v) * width;
  };
  return NoiseScaleOfRows(rows_about, width, height, lag, kNoiseStride, noise);
}

DEEPSLAM_WIDE_VECTORS double RawNoiseScale(const StoredDepth& depth,
                                           int stride,
                                           const DepthNoise& noise) {
  constexpr int kLag = 1;  // px: raw depth has not been smoothed here
  const int width = depth.width();
  std::vector<float> room;
  const auto rows_about = [&](int v) { return depth.Rows(v - kLag, 2 * kLag + 1, room) + width; };
  return NoiseScaleOfRows(rows_about, width, depth.height(), kLag, stride, noise);
}

}  // namespace deepslam
