#include "deepslam/alignment/source_points.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "deepslam/alignment/batch_columns.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::alignment {
namespace {

// Grey levels per pixel: below, the intensity says nothing about motion.
constexpr float kMinGradient = 1.5F;
// What is nearer by less than this share of the depth is the same surface.
constexpr float kSameSurfaceShare = 0.03F;

std::size_t MostPoints(const PyramidLevel& level, int stride) {
  const std::size_t per_row = static_cast<std::size_t>(level.camera.width / stride + 1);
  const std::size_t lanes = (per_row + kLanes - 1) / kLanes * kLanes;
  return lanes * static_cast<std::size_t>(level.camera.height / stride + 1);
}

}  // namespace

SourcePoints::SourcePoints(const PyramidLevel& level, const SourceChoice& choice)
    : level_(level), choice_(choice), photometric_(choice.photometric && !level.intensity.empty()) {
  const std::size_t most = MostPoints(level, choice.stride);
  // Without initial values: these would take as long as a step over the points.
  for (auto* numbers : {&column_, &depth_m_, &rho2_})
    *numbers = std::make_unique_for_overwrite<float[]>(most);
  for (auto* pixels : {&surface_, &intensity_})
    *pixels = std::make_unique_for_overwrite<PackedPixel[]>(most);
  for (auto* flags : {&has_normal_, &has_texture_})
    *flags = std::make_unique_for_overwrite<std::int32_t[]>(most);
  Gather();
}

DEEPSLAM_WIDE_VECTORS void SourcePoints::Gather() {
  SurfaceRow surface(level_.camera.width);
  IntensityRow intensity(level_.camera.width);  // all 0 where intensity does not count
  for (int v = choice_.stride / 2; v < level_.camera.height; v += choice_.stride) {
    const std::size_t begin = size_;
    ReadSurface(level_, v, surface);
    if (photometric_) ReadIntensity(level_.intensity, v, intensity);
    AddRow(v, surface, intensity);
    FillLanes();
    AddRowPieces(v, begin);
  }
}

// Every point is written, and kept by counting it: there is no branch for outlines to mislead.
void SourcePoints::AddRow(int v, const SurfaceRow& surface, const IntensityRow& intensity) {
  const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(v) * level_.camera.width;
  const float* const depth_m = level_.depth_m.data() + start;
  const float *const nx = surface[0], *const ny = surface[1], *const nz = surface[2];
  const float* const offset_m = surface[3];
  const float *const value = intensity[0], *const du = intensity[1], *const dv = intensity[2];
  std::size_t n = size_;
  for (int u = choice_.stride / 2; u < level_.camera.width; u += choice_.stride) {
    const bool has_depth = depth_m[u] > 0;
    const bool has_normal = offset_m[u] < 0;
    bool has_texture = std::abs(du[u]) + std::abs(dv[u]) >= kMinGradient;
    // Outlines of objects have depth but no normal; their intensity still says where they are.
    if (choice_.near & has_texture & has_depth & !has_normal)
      has_texture = ShowsItself(level_, static_cast<std::int32_t>(start) + u);
    column_[n] = static_cast<float>(u);
    depth_m_[n] = depth_m[u];
    surface_[n] = {nx[u], ny[u], nz[u], offset_m[u]};
    intensity_[n] = {value[u], du[u], dv[u], 0};
    has_normal_[n] = has_normal ? 1 : 0;
    has_texture_[n] = has_texture ? 1 : 0;
    num_with_normal_ += has_normal ? 1 : 0;
    n += (has_depth & (has_normal | has_texture)) ? 1 : 0;
  }
  size_ = n;
}

void SourcePoints::FillLanes() {
  for (; size_ % kLanes != 0; ++size_) {
    column_[size_] = depth_m_[size_] = 0;
    surface_[size_] = intensity_[size_] = {0, 0, 0, 0};
    has_normal_[size_] = has_texture_[size_] = 0;
  }
}

void SourcePoints::AddRowPieces(int v, std::size_t begin) {
  const Eigen::Vector2f ray = level_.camera.Ray(0, v).head<2>().cast<float>();
  const float ray_x = ray.x(), ray_y2 = ray.y() * ray.y();
  const float ray_step = 1.0F / static_cast<float>(level_.camera.fx);
  for (std::size_t n = begin; n < size_; ++n) {
    const float tangent = ray_x + column_[n] * ray_step;
    rho2_[n] = tangent * tangent + ray_y2;
  }
  while (begin < size_) {
    const std::size_t end = std::min(size_, (begin / kBatch + 1) * kBatch);
    rows_.push_back({v, begin, end});
    begin = end;
  }
}

bool ShowsItself(const PyramidLevel& level, std::int32_t pixel) {
  const std::int32_t width = level.camera.width, height = level.camera.height;
  const std::int32_t u = pixel % width, v = pixel / width;
  const std::int32_t left = u > 0 ? -1 : 0, right = u + 1 < width ? 1 : 0;
  const float nearest_m = (1 - kSameSurfaceShare) * level.depth_m[static_cast<std::size_t>(pixel)];
  for (std::int32_t y = std::max(0, v - 1); y <= std::min(height - 1, v + 1); ++y) {
    const float* const row_m = level.depth_m.data() + static_cast<std::ptrdiff_t>(y) * width + u;
    for (std::int32_t x = left; x <= right; ++x) {
      if (!(row_m[x] > 0) || row_m[x] < nearest_m) return false;  // mostly the first one says so
    }
  }
  return true;
}

}  // namespace deepslam::alignment
