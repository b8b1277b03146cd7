#include "deepslam/alignment/reference_pixels.h"

#include <cstddef>
#include <utility>

#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::alignment {
namespace {

UnfilledVector<SurfacePixel> SurfaceOf(const PyramidLevel& level) {
  UnfilledVector<SurfacePixel> surface(level.depth_m.size());
  SurfaceRow row(level.camera.width);
  for (int v = 0; v < level.camera.height; ++v) {
    ReadSurface(level, v, row);
    row.WriteTo(surface.data() + static_cast<std::ptrdiff_t>(v) * level.camera.width);
  }
  return surface;
}

UnfilledVector<float> SignedDepthOf(const PyramidLevel& level) {
  UnfilledVector<float> signed_depth_m(level.depth_m.size());
  for (std::size_t k = 0; k < signed_depth_m.size(); ++k)
    signed_depth_m[k] = level.surface[k].offset_m < 0 ? level.depth_m[k] : -level.depth_m[k];
  return signed_depth_m;
}

DEEPSLAM_WIDE_VECTORS void AddPixels(PyramidLevel& level) {
  level.surface = SurfaceOf(level);
  level.signed_depth_m = SignedDepthOf(level);
  level.gradients = WithDerivatives(level.intensity);
}

}  // namespace

bool IsReference(const FramePyramid& pyramid) {
  return !pyramid.empty() && !pyramid.levels.front().surface.empty();
}

FramePyramid AsReference(FramePyramid pyramid) {
  for (PyramidLevel& level : pyramid.levels) AddPixels(level);
  return pyramid;
}

void HidePixel(std::size_t pixel, PyramidLevel& level) {
  level.depth_m[pixel] = 0;
  if (level.surface.empty()) return;
  level.surface[pixel] = SurfacePixel{};
  level.signed_depth_m[pixel] = 0;
}

UnfilledVector<IntensityPixel> WithDerivatives(const IntensityImage& image) {
  UnfilledVector<IntensityPixel> pixels(image.size());
  IntensityRow row(image.width());
  for (int v = 0; v < image.height(); ++v) {
    ReadIntensity(image, v, row);
    row.WriteTo(pixels.data() + static_cast<std::ptrdiff_t>(v) * image.width());
  }
  return pixels;
}

}  // namespace deepslam::alignment
