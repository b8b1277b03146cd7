#include "deepslam/shape/distance_transform.h"

#include <array>
#include <cstddef>

namespace deepslam::shape {
namespace {

constexpr int kSize = kGridSize;
constexpr float kFar = 1e10F;

using Line = std::array<float, kSize>;

// Lower envelope of the parabolas (x - q)^2 + f[q]; kFar entries are no parabola.
void TransformLine(const Line& f, Line& result) {
  std::array<int, kSize> vertex{};
  std::array<float, kSize + 1> bound{};
  int last = -1;
  for (int q = 0; q < kSize; ++q) {
    const float fq = f[static_cast<std::size_t>(q)];
    if (fq >= kFar) continue;
    float start = -kFar;
    while (last >= 0) {
      const int p = vertex[static_cast<std::size_t>(last)];
      const float fp = f[static_cast<std::size_t>(p)];
      start = ((fq + static_cast<float>(q * q)) - (fp + static_cast<float>(p * p))) /
              static_cast<float>(2 * (q - p));
      if (start > bound[static_cast<std::size_t>(last)]) break;
      --last;
    }
    if (last < 0) start = -kFar;
    ++last;
    vertex[static_cast<std::size_t>(last)] = q;
    bound[static_cast<std::size_t>(last)] = start;
    bound[static_cast<std::size_t>(last) + 1] = kFar;
  }
  if (last < 0) {
    result.fill(kFar);
    return;
  }
  std::size_t part = 0;
  for (int x = 0; x < kSize; ++x) {
    while (bound[part + 1] < static_cast<float>(x)) ++part;
    const int q = vertex[part];
    result[static_cast<std::size_t>(x)] =
        static_cast<float>((x - q) * (x - q)) + f[static_cast<std::size_t>(q)];
  }
}

}  // namespace

std::vector<float> SquaredDistanceTo(const VoxelGrid& grid, bool occupied) {
  std::vector<float> squared(grid.occupied.size());
  for (std::size_t n = 0; n < squared.size(); ++n) {
    squared[n] = (grid.occupied[n] != 0) == occupied ? 0.0F : kFar;
  }
  constexpr std::array<std::size_t, 3> kStride = {1, kSize, kSize * kSize};
  Line line{};
  Line transformed{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t stride = kStride[axis];
    const std::size_t stride_a = kStride[(axis + 1) % 3];
    const std::size_t stride_b = kStride[(axis + 2) % 3];
    for (std::size_t a = 0; a < kSize; ++a) {
      for (std::size_t b = 0; b < kSize; ++b) {
        float* const first = squared.data() + a * stride_a + b * stride_b;
        for (std::size_t n = 0; n < kSize; ++n) line[n] = first[n * stride];
        TransformLine(line, transformed);
        for (std::size_t n = 0; n < kSize; ++n) first[n * stride] = transformed[n];
      }
    }
  }
  return squared;
}

}  // namespace deepslam::shape
