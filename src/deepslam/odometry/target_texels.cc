#include "deepslam/odometry/target_texels.h"

#include <cstddef>
#include <utility>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/odometry/texel_rows.h"

namespace deepslam::odometry {
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

DEEPSLAM_WIDE_VECTORS void AddTexels(PyramidLevel& level) {
  level.surface = SurfaceOf(level);
  level.intensity = WithDerivatives(level.brightness);
}

}  // namespace

bool IsTarget(const FramePyramid& pyramid) {
  return !pyramid.empty() && !pyramid.levels.front().surface.empty();
}

FramePyramid AsTarget(FramePyramid pyramid) {
  for (PyramidLevel& level : pyramid.levels) AddTexels(level);
  return pyramid;
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

}  // namespace deepslam::odometry
