#include "deepslam/alignment/image_pyramid.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "deepslam/alignment/depth_reduction.h"
#include "deepslam/alignment/depth_smoothing.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/frames/intensity.h"
#include "deepslam/frames/noise_scale.h"

namespace deepslam::alignment {
namespace {

// Beyond the window of the last smoothing; noise that matching shares between neighbours is seen at
// this lag.
constexpr int kFarLag = 2 * kSmoothingRadius + 1;
// Levels smaller than this hold too little to align.
constexpr int kMinLevelWidth = 16;
constexpr int kMaxReduction = 32;  // of captures 10,000 pixels wide
constexpr int kValidStride = 12;   // every so many rows show the share of pixels with a normal
// Columns looked at for whether there is but one depth; one part in so many may stray at either
// end.
constexpr int kOneDepthColumns = 40;
constexpr std::size_t kOneDepthStrays = 50;  // part of the samples

IntensityImage Halved(const IntensityImage& fine, const PinholeCamera& reduced) {
  IntensityImage result(reduced.width, reduced.height);
  const std::ptrdiff_t width = fine.width();
  for (int v = 0; v < reduced.height; ++v) {
    const float* const upper = fine.data() + 2 * v * width;
    const float* const lower = upper + width;
    float* const out = result.data() + static_cast<std::ptrdiff_t>(v) * reduced.width;
    for (int u = 0; u < reduced.width; ++u)
      out[u] = 0.25F * (upper[2 * u] + upper[2 * u + 1] + lower[2 * u] + lower[2 * u + 1]);
  }
  return result;
}

double LevelNoiseScale(const PyramidLevel& level, int lag, const DepthNoise& noise) {
  return NoiseScaleOf(level.depth_m, level.camera.width, lag, noise);
}

PyramidLevel FinestLevel(const StoredDepth& depth,
                         const PinholeCamera& camera,
                         const PyramidOptions& options) {
  const int factor = WorkReduction(camera, options);
  PyramidLevel level;
  level.camera = camera.Reduced(factor);
  const double raw_scale = RawNoiseScale(depth, kNoiseStride * factor, options.noise);
  level.depth_m = ReduceDepth(depth, level.camera, factor, options, raw_scale);
  if (!options.smooth_depth) return level;
  const double shared = LevelNoiseScale(level, kFarLag, options.noise);
  const double scale =
      std::max(LevelNoiseScale(level, 1, options.noise), shared > kSureNoiseScale ? shared : 1.0);
  // The range weights of a noisy pixel favour its own error; a second pass takes what is left.
  if (scale > 1) level.depth_m = SmoothDepth(level.depth_m, level.camera, options.noise, scale);
  level.depth_m = SmoothDepth(level.depth_m, level.camera, options.noise, 1);
  return level;
}

PyramidLevel Halved(const PyramidLevel& fine, const PyramidOptions& options, double noise_scale) {
  PyramidLevel level;
  level.camera = fine.camera.Reduced(2);
  level.depth_m = HalveDepth(fine, level.camera, options, noise_scale);
  return level;
}

// Nothing where the finest level has another size.
void AddIntensity(IntensityImage finest, std::vector<PyramidLevel>& levels) {
  const PinholeCamera& camera = levels.front().camera;
  if (finest.width() != camera.width || finest.height() != camera.height) return;
  levels.front().intensity = std::move(finest);
  for (std::size_t k = 1; k < levels.size(); ++k)
    levels[k].intensity = Halved(levels[k - 1].intensity, levels[k].camera);
}

// By some rows: those with a normal, of all their pixels.
double ValidShare(const PyramidLevel& level) {
  SurfaceRow row(level.camera.width);
  const float* const offset_m = row[3];
  int num_valid = 0, num_pixels = 0;
  for (int v = kValidStride / 2; v < level.camera.height; v += kValidStride) {
    ReadSurface(level, v, row);
    for (int u = 0; u < level.camera.width; ++u) num_valid += offset_m[u] < 0 ? 1 : 0;
    num_pixels += level.camera.width;
  }
  return num_pixels > 0 ? static_cast<double>(num_valid) / num_pixels : 0;
}

// Of some hundred pixels, but for a few strays; without depth there is none.
bool HasOneDepth(const StoredDepth& depth) {
  std::vector<float> samples;
  const int step = std::max(1, depth.width() / kOneDepthColumns);
  for (int v = step / 2; v < depth.height(); v += step) {
    for (int u = step / 2; u < depth.width(); u += step) {
      if (depth(u, v) > 0) samples.push_back(depth(u, v));
    }
  }
  if (samples.empty()) return false;
  const auto [low, high] = InnerRange(samples, kOneDepthStrays);
  return low == high;
}

}  // namespace

int WorkReduction(const PinholeCamera& camera, const PyramidOptions& options) {
  int factor = 1;
  while (camera.width / factor > options.work_width_px && factor < kMaxReduction) ++factor;
  return factor;
}

FramePyramid BuildPyramid(const Frame& frame,
                          const PinholeCamera& camera,
                          const PyramidOptions& options) {
  const bool fits = frame.colour.width() == camera.width && frame.colour.height() == camera.height;
  const int factor = WorkReduction(camera, options);
  IntensityImage intensity = fits ? IntensityOf(frame.colour, factor) : IntensityImage();
  return BuildPyramid(StoredDepth(frame.depth_m), std::move(intensity), camera, options);
}

DEEPSLAM_WIDE_VECTORS FramePyramid BuildPyramid(const StoredDepth& depth,
                                                IntensityImage intensity,
                                                const PinholeCamera& camera,
                                                const PyramidOptions& options) {
  if (depth.empty() || depth.width() != camera.width || depth.height() != camera.height) return {};
  FramePyramid pyramid;
  pyramid.one_depth = HasOneDepth(depth);
  pyramid.reduction = WorkReduction(camera, options);
  pyramid.levels.push_back(FinestLevel(depth, camera, options));
  // Beyond the window, so that what smoothing shared between neighbours is seen.
  pyramid.noise_scale = LevelNoiseScale(pyramid.levels.front(), kFarLag, options.noise);
  while (static_cast<int>(pyramid.levels.size()) < options.num_levels &&
         pyramid.levels.back().camera.width >= 2 * kMinLevelWidth &&
         pyramid.levels.back().camera.height >= 2 * kMinLevelWidth / 2) {
    pyramid.levels.push_back(Halved(pyramid.levels.back(), options, pyramid.noise_scale));
  }
  for (PyramidLevel& level : pyramid.levels)
    level.noise = options.noise.Scaled(pyramid.noise_scale);
  AddIntensity(std::move(intensity), pyramid.levels);
  pyramid.valid_share = ValidShare(pyramid.levels.front());
  return pyramid;
}

Result<ReadFrame> ReadPyramid(const FrameSource& frames,
                              FrameIdx frame,
                              const PyramidOptions& options) {
  const PinholeCamera& camera = frames.camera();
  Result<StoredDepth> depth = frames.ReadStoredDepth(frame);
  if (!depth.ok()) return depth.error();
  Result<IntensityImage> intensity = frames.ReadIntensity(frame, WorkReduction(camera, options));
  if (!intensity.ok()) return intensity.error();
  FramePyramid pyramid = BuildPyramid(*depth, std::move(*intensity), camera, options);
  if (pyramid.empty()) return InvalidInput("depth image has not the size of the camera");
  return ReadFrame{std::move(pyramid), *std::move(depth)};
}

void Describe(OptionsVisitor& visitor, PyramidOptions& options) {
  visitor.Field("work_width_px",
                options.work_width_px,
                {32, 640},
                "px",
                "finest level: the capture reduced by a whole factor to at most this width");
  visitor.Field(
      "num_levels", options.num_levels, {1, 6}, "1", "levels of the pyramid, each half as wide");
  visitor.Field("min_depth_m", options.min_depth_m, {0.01, 10}, "m", "nearer depth is invalid");
  visitor.Field("max_depth_m", options.max_depth_m, {0.1, 100}, "m", "farther depth is invalid");
  visitor.Field("smooth_depth", options.smooth_depth, "edge-respecting smoothing of the depth");
  visitor.Field("noise_base_m",
                options.noise.base_m,
                {1e-5, 1},
                "m",
                "depth noise at 0.4 m, one standard deviation");
  visitor.Field("noise_growth_per_m",
                options.noise.growth_per_m,
                {0, 1},
                "1/m",
                "depth noise grows by this times the square of the depth beyond 0.4 m");
}

}  // namespace deepslam::alignment
