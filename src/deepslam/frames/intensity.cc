#include "deepslam/frames/intensity.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "deepslam/core/check.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam {
namespace {

constexpr int kMaxSummed = 32;  // sums of so many rows of bytes take 13 bits

// Adds a row's bytes to the sums of the rows before: whole vectors of them, whatever the channel.
void AddBytes(const Rgb8* row, std::vector<std::uint16_t>& sums) {
  static_assert(sizeof(Rgb8) == 3);
  const std::uint8_t* const bytes = &row->r;
  for (std::size_t n = 0; n < sums.size(); ++n)
    sums[n] = static_cast<std::uint16_t>(sums[n] + bytes[n]);
}

// Luma of `factor` pixels next to each other, in 1/256.
int Luma(const std::uint16_t* rgb, int factor) {
  int r = 0, g = 0, b = 0;
  for (int du = 0; du < factor; ++du) {
    r += rgb[3 * du];
    g += rgb[3 * du + 1];
    b += rgb[3 * du + 2];
  }
  return 77 * r + 150 * g + 29 * b;
}

DEEPSLAM_WIDE_VECTORS IntensityImage MeanLuma(const ColourImage& colour, int factor) {
  IntensityImage result(colour.width() / factor, colour.height() / factor);
  const float scale = 1.0F / (256.0F * static_cast<float>(factor * factor));
  std::vector<std::uint16_t> sums(3 * static_cast<std::size_t>(result.width() * factor));
  for (int v = 0; v < result.height(); ++v) {
    std::fill(sums.begin(), sums.end(), std::uint16_t{0});
    for (int dv = 0; dv < factor; ++dv) AddBytes(colour.row(v * factor + dv), sums);
    float* const out = result.row(v);
    for (int u = 0; u < result.width(); ++u) {
      const std::uint16_t* const block = sums.data() + static_cast<std::ptrdiff_t>(3) * u * factor;
      // 2, the factor of VGA, unrolled.
      const int luma = factor == 2 ? Luma(block, 2) : Luma(block, factor);
      out[u] = scale * static_cast<float>(luma);
    }
  }
  return result;
}

}  // namespace

IntensityImage IntensityOf(const ColourImage& colour, int factor) {
  DEEPSLAM_CHECK(factor >= 1, "blocks of at least one pixel");
  if (factor <= kMaxSummed) return MeanLuma(colour, factor);
  return ReducedIntensity(MeanLuma(colour, 1), factor);
}

IntensityImage ReducedIntensity(const IntensityImage& intensity, int factor) {
  DEEPSLAM_CHECK(factor >= 1, "blocks of at least one pixel");
  IntensityImage result(intensity.width() / factor, intensity.height() / factor);
  const float share = 1.0F / static_cast<float>(factor * factor);
  for (int v = 0; v < result.height(); ++v) {
    for (int u = 0; u < result.width(); ++u) {
      float sum = 0;
      for (int y = v * factor; y < (v + 1) * factor; ++y) {
        const float* const block = intensity.row(y) + static_cast<std::ptrdiff_t>(u) * factor;
        for (int x = 0; x < factor; ++x) sum += block[x];
      }
      result(u, v) = share * sum;
    }
  }
  return result;
}

}  // namespace deepslam
