#include "deepslam/frames/local_contrast.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

namespace deepslam {
namespace {

// Wider than grain that is seen at all, and narrower than most shading.
constexpr int kRadius = 3;
// Added to the deviation, grey levels: what is left of a camera's noise where pixels of a reduced
// image are means of ten and more.
constexpr float kNoiseGreys = 0.25F;

// Means over 2 kRadius + 1 neighbours of `count` numbers `step` apart.
void Smooth(const float* from, float* to, int count, std::ptrdiff_t step) {
  float sum = 0;
  for (int k = 0; k < std::min(kRadius, count); ++k) sum += from[k * step];
  for (int k = 0; k < count; ++k) {
    if (k + kRadius < count) sum += from[(k + kRadius) * step];
    if (k - kRadius > 0) sum -= from[(k - kRadius - 1) * step];
    const int num = std::min(count - 1, k + kRadius) - std::max(0, k - kRadius) + 1;
    to[k * step] = sum / static_cast<float>(num);
  }
}

Image<float> Smoothed(const Image<float>& image) {
  Image<float> rows(image.width(), image.height()), result(image.width(), image.height());
  for (int v = 0; v < image.height(); ++v) Smooth(image.row(v), rows.row(v), image.width(), 1);
  for (int u = 0; u < image.width(); ++u)
    Smooth(rows.data() + u, result.data() + u, image.height(), image.width());
  return result;
}

}  // namespace

Image<float> NormaliseLocalContrast(const Image<float>& image) {
  Image<float> detail = Smoothed(image);
  std::ranges::transform(image, detail, detail.begin(), std::minus<float>());
  Image<float> variance = detail;
  for (float& value : variance) value *= value;
  variance = Smoothed(variance);
  const auto normalised = [](float value, float squared) {
    return value / std::sqrt(std::max(0.0F, squared) + kNoiseGreys * kNoiseGreys);
  };
  std::ranges::transform(detail, variance, detail.begin(), normalised);
  return detail;
}

}  // namespace deepslam
