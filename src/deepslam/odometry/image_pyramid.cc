#include "deepslam/odometry/image_pyramid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>

#include <Eigen/Geometry>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/scene/brightness.h"

namespace deepslam::odometry {
namespace {

// Depth of one surface within a block or window differs by at most this many standard deviations of
// its noise.
constexpr float kSameSurfaceSigmas = 4.0F;
// Cosine between normal and viewing ray below which a surface is too oblique for projective
// association.
constexpr float kMinCosine = 0.12F;
constexpr int kWindowRadius = 2;
// Noise is measured between 1 and this many times the model's: beyond, depth says nothing.
constexpr double kMaxNoiseScale = 8.0;
// Beyond the window of the last smoothing; noise that matching shares between neighbours is seen at
// this lag. Up to the second value it may as well be the scene's own relief.
constexpr int kFarLag = 2 * kWindowRadius + 1;
constexpr double kSureNoiseScale = 1.5;
// The median over every fifth texel of every fifth row is as good as that over all.
constexpr int kNoiseStride = 5;
// Fewer second differences say nothing about the noise.
constexpr std::size_t kMinDifferences = 100;
constexpr float kMadToSigma = 1.4826F;
// Levels smaller than this hold too little to align.
constexpr int kMinLevelWidth = 16;
constexpr int kMaxReduction = 32;
// Columns looked at for whether there is but one depth; one part in so many may stray at either
// end.
constexpr int kOneDepthColumns = 40;
constexpr std::size_t kOneDepthStrays = 50;

std::size_t Offset(const PinholeCamera& camera, int u, int v) {
  return static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) +
         static_cast<std::size_t>(u);
}

std::size_t NumTexels(const PinholeCamera& camera) { return Offset(camera, 0, camera.height); }

// Second differences of the inverse depth vanish on planes, however oblique. Times z^2 they are
// those of the depth, 2.45 = sqrt(1 + 1 + 4) times as wide as its noise.
void AddDifference(
    float before, float centre, float after, float inverse_sigma, std::vector<float>& differences) {
  if (!(before > 0) || !(after > 0)) return;
  const float difference = centre * (centre / before + centre / after - 2.0F);
  const float normalised = std::abs(difference) * inverse_sigma;
  if (std::isfinite(normalised)) differences.push_back(normalised);
}

// Deviation of the depth in units of `noise`, from texels `lag` apart: the median, so that half of
// the image may be edges. Noise shared over more than `lag` texels is not seen.
double NoiseScale(
    const float* depth, int width, int height, int lag, int stride, const DepthNoise& noise) {
  std::vector<float> differences;
  differences.reserve(2 * static_cast<std::size_t>(width / stride) *
                      static_cast<std::size_t>(height / stride));
  for (int v = lag; v + lag < height; v += stride) {
    const float* row = depth + static_cast<std::ptrdiff_t>(v) * width;
    const std::ptrdiff_t down = static_cast<std::ptrdiff_t>(lag) * width;
    for (int u = lag; u + lag < width; u += stride) {
      const float z = row[u];
      if (!(z > 0) || !std::isfinite(z)) continue;
      const float inverse_sigma = 1.0F / (2.44948974F * noise.SigmaM(z));
      AddDifference(row[u - lag], z, row[u + lag], inverse_sigma, differences);
      AddDifference(row[u - down], z, row[u + down], inverse_sigma, differences);
    }
  }
  if (differences.size() < kMinDifferences) return 1.0;
  return std::clamp(static_cast<double>(kMadToSigma * Median(differences)), 1.0, kMaxNoiseScale);
}

double NoiseScale(const PyramidLevel& level, int lag, const DepthNoise& noise) {
  return NoiseScale(
      level.depth_m.data(), level.camera.width, level.camera.height, lag, kNoiseStride, noise);
}

// Mean of the values that lie on the surface of the median one; 0 when there are none.
float BlockDepth(std::span<float> values, const DepthNoise& noise) {
  if (values.empty()) return 0;
  const auto [least, most] = std::ranges::minmax(values);
  // Mostly all are of one surface whichever the median is.
  if (most - least <= kSameSurfaceSigmas * noise.SigmaM(0.4F) + 0.01F * least) {
    return std::accumulate(values.begin(), values.end(), 0.0F) / static_cast<float>(values.size());
  }
  const float median = OrderStatistic(values, (values.size() - 1) / 2);
  const float tolerance = kSameSurfaceSigmas * noise.SigmaM(median) + 0.01F * median;
  float sum = 0;
  float count = 0;
  for (const float value : values) {
    const bool same = std::abs(value - median) <= tolerance;
    sum += same ? value : 0;
    count += same ? 1.0F : 0;
  }
  return sum / count;
}

// What BlockDepth makes of the four pixels of which `upper` and `lower` are the first ones, where
// all are valid and of one surface or none is valid, as nearly everywhere; else below 0.
float SimpleBlock(
    const float* upper, const float* lower, float min_depth, float max_depth, float tolerance) {
  const float least = std::min(std::min(upper[0], upper[1]), std::min(lower[0], lower[1]));
  const float most = std::max(std::max(upper[0], upper[1]), std::max(lower[0], lower[1]));
  const float sum = upper[0] + upper[1] + lower[0] + lower[1];  // NaN where one is
  const bool simple = (least >= min_depth) & (most <= max_depth) & (sum == sum) &
                      (most - least <= tolerance + 0.01F * least);
  const bool none = ((most < min_depth) | (least > max_depth)) & (sum == sum);
  if (none) return 0;
  return simple ? sum / 4.0F : -1.0F;
}

// Valid depths of a block of factor x factor pixels are gathered and reduced to one.
std::vector<float> ReduceDepth(const float* depth,
                               int width,
                               const PinholeCamera& reduced,
                               int factor,
                               const PyramidOptions& options,
                               double noise_scale) {
  const DepthNoise noise = options.noise.Scaled(noise_scale);
  const float min_depth = static_cast<float>(options.min_depth_m);
  const float max_depth = static_cast<float>(options.max_depth_m);
  std::vector<float> result(NumTexels(reduced), -1.0F);
  std::vector<float> block(static_cast<std::size_t>(factor) * static_cast<std::size_t>(factor));
  const float tolerance = kSameSurfaceSigmas * noise.SigmaM(0.4F);
  for (int v = 0; v < reduced.height; ++v) {
    if (factor == 2) {
      const float* const upper = depth + static_cast<std::ptrdiff_t>(2 * v) * width;
      float* const out = result.data() + Offset(reduced, 0, v);
      for (int u = 0; u < reduced.width; ++u)
        out[u] = SimpleBlock(upper + 2 * u, upper + width + 2 * u, min_depth, max_depth, tolerance);
    }
    for (int u = 0; u < reduced.width; ++u) {
      if (result[Offset(reduced, u, v)] >= 0) continue;
      std::size_t count = 0;
      for (int dv = 0; dv < factor; ++dv) {
        const float* row =
            depth + static_cast<std::ptrdiff_t>(v * factor + dv) * width + u * factor;
        for (int du = 0; du < factor; ++du) {
          block[count] = row[du];  // NaN fails both comparisons
          const bool valid = (row[du] >= min_depth) & (row[du] <= max_depth);
          count += valid ? 1 : 0;
        }
      }
      result[Offset(reduced, u, v)] = BlockDepth({block.data(), count}, noise);
    }
  }
  return result;
}

// Sums of a row of the smoothing window over a row of texels.
struct WindowSums {
  explicit WindowSums(std::size_t width)
      : inverse_tolerance_sq(width), difference(width), weight(width) {}
  std::vector<float> inverse_tolerance_sq, difference, weight;
};

// One tap for columns begin ... end - 1; depth 0 is too far off to get weight.
void AddTap(
    const float* centre, const float* tap, float tap_weight, int begin, int end, WindowSums& sums) {
  const float* const inverse_tolerance_sq = sums.inverse_tolerance_sq.data();
  float* const sum = sums.difference.data();
  float* const sum_weight = sums.weight.data();
#pragma GCC ivdep
  for (int u = begin; u < end; ++u) {
    const float difference = tap[u] - centre[u];
    const float w =
        tap_weight * std::max(0.0F, 1.0F - difference * difference * inverse_tolerance_sq[u]);
    sum[u] += w * difference;
    sum_weight[u] += w;
  }
}

// All taps of a row of the usual window at once, where none falls outside: sums stay in registers.
void AddUsualTaps(
    const float* centre, const float* row, const float* tap_weights, int width, WindowSums& sums) {
  const float* const inverse_tolerance_sq = sums.inverse_tolerance_sq.data();
  float* const sum = sums.difference.data();
  float* const sum_weight = sums.weight.data();
  static_assert(kWindowRadius == 2);
  const float w0 = tap_weights[0], w1 = tap_weights[1], w2 = tap_weights[2], w3 = tap_weights[3],
              w4 = tap_weights[4];
#pragma GCC ivdep
  for (int u = kWindowRadius; u < width - kWindowRadius; ++u) {
    const float middle = centre[u], inverse = inverse_tolerance_sq[u];
    float of_row = sum[u], weight_of_row = sum_weight[u];
    const auto add = [&](float depth, float tap_weight) {
      const float difference = depth - middle;
      const float w = tap_weight * std::max(0.0F, 1.0F - difference * difference * inverse);
      of_row += w * difference;
      weight_of_row += w;
    };
    add(row[u - 2], w0);
    add(row[u - 1], w1);
    add(row[u], w2);
    add(row[u + 1], w3);
    add(row[u + 2], w4);
    sum[u] = of_row;
    sum_weight[u] = weight_of_row;
  }
}

// Taps `row`[u - radius] ... [u + radius] for every column u.
void AddTaps(const float* centre,
             const float* row,
             const std::vector<float>& tap_weights,
             int width,
             WindowSums& sums) {
  const int radius = static_cast<int>(tap_weights.size() / 2);
  const bool usual = radius == kWindowRadius && width > 2 * radius;
  if (usual) AddUsualTaps(centre, row, tap_weights.data(), width, sums);
  for (int du = -radius; du <= radius; ++du) {
    const float weight = tap_weights[static_cast<std::size_t>(du + radius)];
    const int begin = std::min(width, std::max(0, -du));
    const int end = std::max(begin, std::min(width, width - du));
    const int left = usual ? radius : end, right = usual ? width - radius : end;
    AddTap(centre, row + du, weight, begin, std::min(left, end), sums);
    AddTap(centre, row + du, weight, std::max(begin, right), end, sums);
  }
}

int WindowRadius(double noise_scale) {
  return static_cast<int>(std::lround(kWindowRadius * std::sqrt(noise_scale)));
}

// Weighted mean over a window of what lies on the same surface (a bilateral filter with the depth
// noise as range). The slope of white noise smoothed over a window falls with the window's area, so
// an area in proportion to the noise keeps the normals as good as they are at scale 1.
std::vector<float> SmoothDepth(const std::vector<float>& depth,
                               const PinholeCamera& camera,
                               const DepthNoise& model,
                               double noise_scale) {
  const DepthNoise noise = model.Scaled(noise_scale);
  const int radius = WindowRadius(noise_scale);
  const float spread = 4.5F * static_cast<float>(noise_scale);
  const std::size_t width = static_cast<std::size_t>(camera.width);
  std::vector<float> result(depth.size());
  WindowSums sums(width);
  std::vector<float> tap_weights(static_cast<std::size_t>(2 * radius + 1));
  for (int v = 0; v < camera.height; ++v) {
    const float* centre = depth.data() + Offset(camera, 0, v);
    for (std::size_t u = 0; u < width; ++u) {
      // The tolerance stays below the depth itself, so that invalid neighbours get no weight.
      const float tolerance =
          std::min(kSameSurfaceSigmas * noise.SigmaM(centre[u]), 0.5F * centre[u] + 1e-6F);
      sums.inverse_tolerance_sq[u] = 1.0F / (tolerance * tolerance);
      sums.difference[u] = 0;
      sums.weight[u] = 1e-6F;
    }
    for (int dv = -radius; dv <= radius; ++dv) {
      if (v + dv < 0 || v + dv >= camera.height) continue;
      for (int du = -radius; du <= radius; ++du) {
        tap_weights[static_cast<std::size_t>(du + radius)] =
            std::exp(-static_cast<float>(du * du + dv * dv) / spread);
      }
      AddTaps(centre, depth.data() + Offset(camera, 0, v + dv), tap_weights, camera.width, sums);
    }
    float* out = result.data() + Offset(camera, 0, v);
    for (std::size_t u = 0; u < width; ++u) {
      out[u] = centre[u] > 0 ? centre[u] + sums.difference[u] / sums.weight[u] : 0.0F;
    }
  }
  return result;
}

// One row of normals, one array per quantity so that the loop is vectorised.
struct SurfaceRow {
  explicit SurfaceRow(int width)
      : nx(static_cast<std::size_t>(width)), ny(nx.size()), nz(nx.size()), offset_m(nx.size()) {}
  std::vector<float> nx, ny, nz, offset_m;
};

// A texel has a normal where the three texels in its row and in its column lie on one surface, a
// slope being fine, a step or crease not, and that surface is not too oblique.
void ComputeRow(const PyramidLevel& level, int v, const DepthNoise& noise, SurfaceRow& row) {
  const PinholeCamera& camera = level.camera;
  const float* const depth = level.depth_m.data() + Offset(camera, 0, v);
  const float* const above = depth - camera.width;
  const float* const below = depth + camera.width;
  const float inverse_fx = static_cast<float>(1.0 / camera.fx);
  const float inverse_fy = static_cast<float>(1.0 / camera.fy);
  const float cx = static_cast<float>(camera.cx);
  const float y = (static_cast<float>(v) - static_cast<float>(camera.cy)) * inverse_fy;
  const float base = kSameSurfaceSigmas * static_cast<float>(noise.base_m);
  const float growth = kSameSurfaceSigmas * static_cast<float>(noise.growth_per_m);
  float* const nx = row.nx.data();
  float* const ny = row.ny.data();
  float* const nz = row.nz.data();
  float* const offset_m = row.offset_m.data();
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
                            (-along >= kMinCosine * norm * ray);
    const float inverse_norm = has_normal ? 1.0F / norm : 0.0F;
    nx[u] = cross_x * inverse_norm;
    ny[u] = cross_y * inverse_norm;
    nz[u] = cross_z * inverse_norm;
    offset_m[u] = z * along * inverse_norm;
  }
}

// Row by row, so that each texel is written once. Gives the number of texels with a normal.
int ComputeSurface(PyramidLevel& level, const DepthNoise& noise) {
  const std::size_t width = static_cast<std::size_t>(level.camera.width);
  level.surface.clear();
  level.surface.reserve(NumTexels(level.camera));
  SurfaceRow row(level.camera.width);
  std::vector<SurfaceTexel> texels(width);
  const auto append = [&] {
    level.surface.insert(level.surface.end(), texels.begin(), texels.end());
  };
  append();  // the first row has no neighbour above, the last none below
  int num_normals = 0;
  for (int v = 1; v + 1 < level.camera.height; ++v) {
    ComputeRow(level, v, noise, row);
    for (std::size_t u = 1; u + 1 < width; ++u) {
      texels[u] = {row.nx[u], row.ny[u], row.nz[u], row.offset_m[u]};
      num_normals += row.offset_m[u] < 0 ? 1 : 0;
    }
    append();
  }
  if (level.camera.height > 1) {
    texels.assign(width, {});
    append();
  }
  return num_normals;
}

// The image and its derivatives, which are 0 at the border.
std::vector<IntensityTexel> WithGradients(const BrightnessImage& image) {
  const int width = image.width(), height = image.height();
  std::vector<IntensityTexel> result;
  result.reserve(image.size());
  std::vector<IntensityTexel> texels(static_cast<std::size_t>(width));
  std::vector<float> du(texels.size()), dv(texels.size());
  for (int v = 0; v < height; ++v) {
    const float* const row = image.data() + static_cast<std::ptrdiff_t>(v) * width;
    const bool inside = v > 0 && v + 1 < height;
    const float *const above = inside ? row - width : row, *const below =
                                                               inside ? row + width : row;
    for (std::size_t u = 1; u + 1 < texels.size(); ++u) {
      du[u] = inside ? 0.5F * (row[u + 1] - row[u - 1]) : 0.0F;
      dv[u] = 0.5F * (below[u] - above[u]);
    }
    for (std::size_t u = 0; u < texels.size(); ++u) texels[u] = {row[u], du[u], dv[u]};
    result.insert(result.end(), texels.begin(), texels.end());
  }
  return result;
}

BrightnessImage Halved(const BrightnessImage& fine, const PinholeCamera& reduced) {
  BrightnessImage result(reduced.width, reduced.height);
  const std::ptrdiff_t width = fine.width();
  for (int v = 0; v < reduced.height; ++v) {
    const float* const upper = fine.data() + 2 * v * width;
    const float* const lower = upper + width;
    float* const out = result.data() + Offset(reduced, 0, v);
    for (int u = 0; u < reduced.width; ++u)
      out[u] = 0.25F * (upper[2 * u] + upper[2 * u + 1] + lower[2 * u] + lower[2 * u + 1]);
  }
  return result;
}

PyramidLevel FinestLevel(const DepthImage& depth_m,
                         const PinholeCamera& camera,
                         const PyramidOptions& options) {
  const int factor = WorkReduction(camera, options);
  PyramidLevel level;
  level.camera = camera.Reduced(factor);
  const float* depth = depth_m.data();
  const double raw_scale =
      NoiseScale(depth, camera.width, camera.height, 1, kNoiseStride * factor, options.noise);
  level.depth_m = ReduceDepth(depth, camera.width, level.camera, factor, options, raw_scale);
  if (options.smooth_depth) {
    const double shared = NoiseScale(level, kFarLag, options.noise);
    const double scale =
        std::max(NoiseScale(level, 1, options.noise), shared > kSureNoiseScale ? shared : 1.0);
    // The range weights of a noisy texel favour its own error; a second pass takes what is left.
    if (scale > 1) {
      level.depth_m = SmoothDepth(level.depth_m, level.camera, options.noise, scale);
    }
    level.depth_m = SmoothDepth(level.depth_m, level.camera, options.noise, 1);
  }
  return level;
}

PyramidLevel Halved(const PyramidLevel& fine, const PyramidOptions& options, double noise_scale) {
  PyramidLevel level;
  level.camera = fine.camera.Reduced(2);
  level.depth_m =
      ReduceDepth(fine.depth_m.data(), fine.camera.width, level.camera, 2, options, noise_scale);
  return level;
}

// Nothing where the finest level has another size.
void AddIntensity(const BrightnessImage& finest, std::vector<PyramidLevel>& levels) {
  const PinholeCamera& camera = levels.front().camera;
  if (finest.width() != camera.width || finest.height() != camera.height) return;
  levels.front().intensity = WithGradients(finest);
  BrightnessImage halved;
  for (std::size_t k = 1; k < levels.size(); ++k) {
    halved = Halved(k == 1 ? finest : halved, levels[k].camera);
    levels[k].intensity = WithGradients(halved);
  }
}

// Of some hundred pixels, but for a few strays; without depth there is nothing to tell.
bool HasOneDepth(const DepthImage& depth_m) {
  std::vector<float> samples;
  const int step = std::max(1, depth_m.width() / kOneDepthColumns);
  for (int v = step / 2; v < depth_m.height(); v += step) {
    for (int u = step / 2; u < depth_m.width(); u += step) {
      if (depth_m(u, v) > 0) samples.push_back(depth_m(u, v));
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
  const BrightnessImage brightness = fits ? BrightnessOf(frame.colour, factor) : BrightnessImage();
  return BuildPyramid(frame.depth_m, brightness, camera, options);
}

DEEPSLAM_WIDE_VECTORS FramePyramid BuildPyramid(const DepthImage& depth_m,
                                                const BrightnessImage& brightness,
                                                const PinholeCamera& camera,
                                                const PyramidOptions& options) {
  if (depth_m.empty() || depth_m.width() != camera.width || depth_m.height() != camera.height)
    return {};
  FramePyramid pyramid;
  pyramid.one_depth = HasOneDepth(depth_m);
  pyramid.levels.push_back(FinestLevel(depth_m, camera, options));
  // Beyond the window, so that what smoothing shared between neighbours is seen.
  pyramid.noise_scale = NoiseScale(pyramid.levels.front(), kFarLag, options.noise);
  while (static_cast<int>(pyramid.levels.size()) < options.num_levels &&
         pyramid.levels.back().camera.width >= 2 * kMinLevelWidth &&
         pyramid.levels.back().camera.height >= 2 * kMinLevelWidth / 2) {
    pyramid.levels.push_back(Halved(pyramid.levels.back(), options, pyramid.noise_scale));
  }
  std::vector<int> num_normals;
  for (PyramidLevel& level : pyramid.levels)
    num_normals.push_back(ComputeSurface(level, options.noise.Scaled(pyramid.noise_scale)));
  AddIntensity(brightness, pyramid.levels);
  const PyramidLevel& finest = pyramid.levels.front();
  if (!finest.surface.empty())
    pyramid.valid_share = num_normals.front() / static_cast<double>(finest.surface.size());
  return pyramid;
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

}  // namespace deepslam::odometry
