#include "deepslam/alignment/reference_pixels.h"

#include <cstddef>
#include <utility>

#include "deepslam/alignment/texel_rows.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::alignment {
namespace {

UnfilledVector<SurfaceTexel> SurfaceOf(const PyramidLevel& level) {
  UnfilledVector<SurfaceTexel> surface(level.depth_m.size());
  SurfaceRow row(level.camera.width);
  for (int v = 0; v < level.camera.height; ++v) {
    ReadSurface(level, v, row);
    row.WriteTo(surface.data() + static_cast<std::ptrdiff_t>(v) * level.camera.width);
  }
  return surface;
}

UnfilledVector<float> SightOf(const PyramidLevel& level) {
  UnfilledVector<float> sight_m(level.depth_m.size());
  for (std::size_t k = 0; k < sight_m.size(); ++k)
    sight_m[k] = level.surface[k].offset_m < 0 ? level.depth_m[k] : -level.depth_m[k];
  return sight_m;
}

DEEPSLAM_WIDE_VECTORS void AddTexels(PyramidLevel& level) {
  level.surface = SurfaceOf(level);
  level.sight_m = SightOf(level);
  level.intensity = WithDerivatives(level.brightness);
}

}  // namespace

bool IsReference(const FramePyramid& pyramid) {
  return !pyramid.empty() && !pyramid.levels.front().surface.empty();
}

FramePyramid AsReference(FramePyramid pyramid) {
  for (PyramidLevel& level : pyramid.levels) AddTexels(level);
  return pyramid;
}

void HidePixel(std::size_t texel, PyramidLevel& level) {
  level.depth_m[texel] = 0;
  if (level.surface.empty()) return;
  level.surface[texel] = SurfaceTexel{};
  level.sight_m[texel] = 0;
}

UnfilledVector<IntensityTexel> WithDerivatives(const BrightnessImage& image) {
  UnfilledVector<IntensityTexel> texels(image.size());
  IntensityRow row(image.width());
  for (int v = 0; v < image.height(); ++v) {
    ReadIntensity(image, v, row);
    row.WriteTo(texels.data() + static_cast<std::ptrdiff_t>(v) * image.width());
  }
  return texels;
}

}  // namespace deepslam::alignment
