// What other frames are aligned to: each pixel's tangent plane, and its intensity with derivatives.
// Keyframes alone need them, of every pixel; a frame that is aligned brings a few rows
// (SourcePoints).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/geometry/four_floats.h"

namespace deepslam::alignment {

[[nodiscard]] bool IsReference(const FramePyramid& pyramid);

// The same with pixels on all levels.
[[nodiscard]] FramePyramid AsReference(FramePyramid pyramid);

// The pixel has no depth any more and, on a reference's level, no surface that others could find.
void HidePixel(std::size_t pixel, PyramidLevel& level);

[[nodiscard]] UnfilledVector<IntensityPixel> WithDerivatives(const IntensityImage& image);

// What a row of a level shows: normals and tangent planes from the depth, intensity with its
// derivatives. One array per quantity, so that loops are vectorised; then pixels.
template <typename Pixel>
class PixelRow {
 public:
  explicit PixelRow(int width) : size_(static_cast<std::size_t>(width)) {
    for (std::vector<float>& numbers : numbers_) numbers.resize(size_);
  }

  // In the order of the pixel's members.
  [[nodiscard]] float* operator[](std::size_t quantity) { return numbers_[quantity].data(); }
  [[nodiscard]] const float* operator[](std::size_t quantity) const {
    return numbers_[quantity].data();
  }

  void Clear() {
    for (std::vector<float>& numbers : numbers_) std::ranges::fill(numbers, 0.0F);
  }
  void WriteTo(Pixel* pixels_of_row) const {
    float* to = &FirstOf(*pixels_of_row);
    std::size_t k = 0;
    for (; k + 4 < size_; k += 4, to += 4 * kNumbers) {
      const FourByFour pixels = Transposed({FourFrom(&numbers_[0][k]),
                                            FourFrom(&numbers_[1][k]),
                                            FourFrom(&numbers_[2][k]),
                                            FourFrom(&numbers_[kNumbers - 1][k])});
      // Where a pixel has three numbers the next one begins with the fourth.
      WriteFour(pixels.a, to);
      WriteFour(pixels.b, to + kNumbers);
      WriteFour(pixels.c, to + 2 * kNumbers);
      WriteFour(pixels.d, to + 3 * kNumbers);
    }
    for (; k < size_; ++k) {
      for (const std::vector<float>& numbers : numbers_) *to++ = numbers[k];
    }
  }

 private:
  static constexpr std::size_t kNumbers = sizeof(Pixel) / sizeof(float);
  static_assert(kNumbers == 3 || kNumbers == 4);
  static float& FirstOf(SurfacePixel& pixel) { return pixel.nx; }
  static float& FirstOf(IntensityPixel& pixel) { return pixel.value; }

  std::size_t size_;
  std::array<std::vector<float>, kNumbers> numbers_;
};

using SurfaceRow = PixelRow<SurfacePixel>;
using IntensityRow = PixelRow<IntensityPixel>;

// A pixel has a normal where the three pixels in its row and in its column lie on one surface, a
// slope being fine, a step or crease not, and that surface is not too oblique.
inline void ReadSurface(const PyramidLevel& level, int v, SurfaceRow& row) {
  // Cosine between normal and viewing ray below which a surface is too oblique for projective
  // association.
  constexpr float kMinReferenceCosine = 0.12F;
  const PinholeCamera& camera = level.camera;
  // The first row has no neighbour above, the last none below.
  if (v == 0 || v + 1 == camera.height) return row.Clear();
  const float* const depth = level.depth_m.data() + static_cast<std::ptrdiff_t>(v) * camera.width;
  const float* const above = depth - camera.width;
  const float* const below = depth + camera.width;
  const float inverse_fx = static_cast<float>(1.0 / camera.fx);
  const float inverse_fy = static_cast<float>(1.0 / camera.fy);
  const float cx = static_cast<float>(camera.cx);
  const float y = (static_cast<float>(v) - static_cast<float>(camera.cy)) * inverse_fy;
  const float base = kSameSurfaceSigmas * static_cast<float>(level.noise.base_m);
  const float growth = kSameSurfaceSigmas * static_cast<float>(level.noise.growth_per_m);
  float *const nx = row[0], *const ny = row[1], *const nz = row[2], *const offset_m = row[3];
  const int last = camera.width - 1;
#pragma GCC ivdep
  for (int u = 1; u < last; ++u) {
    const float z = depth[u];
    const float left = depth[u - 1], right = depth[u + 1], up = above[u], down = below[u];
    const float tolerance = base + growth * (z - 0.4F) * (z - 0.4F) + 0.005F * z;
    const float x = (static_cast<float>(u) - cx) * inverse_fx;
    // Differences of the neighbours' points; v x u points towards the camera, as y is down and z
    // forward.
    const float ux = (x + inverse_fx) * right - (x - inverse_fx) * left;
    const float uy = y * (right - left), uz = right - left;
    const float vx = x * (down - up), vz = down - up;
    const float vy = (y + inverse_fy) * down - (y - inverse_fy) * up;
    const float cross_x = vy * uz - vz * uy;
    const float cross_y = vz * ux - vx * uz;
    const float cross_z = vx * uy - vy * ux;
    const float norm = std::sqrt(cross_x * cross_x + cross_y * cross_y + cross_z * cross_z);
    const float along = cross_x * x + cross_y * y + cross_z;
    const float ray = std::sqrt(x * x + y * y + 1.0F);
    const bool has_normal = (z > 0) & (left > 0) & (right > 0) & (up > 0) & (down > 0) &
                            (norm > 0) & (std::abs(left + right - 2 * z) <= tolerance) &
                            (std::abs(up + down - 2 * z) <= tolerance) &
                            (-along >= kMinReferenceCosine * norm * ray);
    const float inverse_norm = has_normal ? 1.0F / norm : 0.0F;
    nx[u] = cross_x * inverse_norm;
    ny[u] = cross_y * inverse_norm;
    nz[u] = cross_z * inverse_norm;
    offset_m[u] = z * along * inverse_norm;
  }
}

// Derivatives are 0 at the border.
inline void ReadIntensity(const IntensityImage& image, int v, IntensityRow& row) {
  const int width = image.width();
  const float* const middle = image.row(v);
  const bool inside = v > 0 && v + 1 < image.height();
  const float* const above = inside ? middle - width : middle;
  const float* const below = inside ? middle + width : middle;
  float *const value = row[0], *const du = row[1], *const dv = row[2];
  std::copy_n(middle, width, value);
  for (int u = 1; u + 1 < width; ++u) {
    du[u] = inside ? 0.5F * (middle[u + 1] - middle[u - 1]) : 0.0F;
    dv[u] = 0.5F * (below[u] - above[u]);
  }
}

}  // namespace deepslam::alignment
