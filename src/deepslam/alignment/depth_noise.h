// Noise of measured depth: the model, and how far a frame is from it.
#pragma once

#include <span>

#include "deepslam/frames/stored_depth.h"

namespace deepslam::alignment {

// Depth noise of structured-light and time-of-flight cameras along the ray, one standard deviation
// (Nguyen et al. 2012): sigma(z) = base_m + growth_per_m * (z - 0.4)^2.
struct DepthNoise {
  double base_m = 0.0012;
  double growth_per_m = 0.0019;

  [[nodiscard]] float SigmaM(float z_m) const {
    const float beyond = z_m - 0.4F;
    return static_cast<float>(base_m) + static_cast<float>(growth_per_m) * beyond * beyond;
  }

  [[nodiscard]] DepthNoise Scaled(double scale) const {
    return {scale * base_m, scale * growth_per_m};
  }
};

// Depth of one surface within a block or window differs by at most this many standard deviations of
// its noise.
inline constexpr float kSameSurfaceSigmas = 4.0F;

// Noise is measured between 1 and this many times the model's: beyond, depth says nothing.
inline constexpr double kMaxNoiseScale = 8.0;

// The median over every seventh pixel of every seventh row is as good as that over all.
inline constexpr int kNoiseStride = 7;

// Deviation of the depth in units of `noise`, from pixels `lag` apart: the median, so that half of
// the image may be edges. Noise shared over more than `lag` pixels is not seen. 1 where too little
// is measured. Depth row by row, `width` pixels each; 0 is invalid.
[[nodiscard]] double NoiseScaleOf(std::span<const float> depth_m,
                                  int width,
                                  int lag,
                                  const DepthNoise& noise);

// The same of depth as it is stored, between neighbours, by every stride-th pixel.
[[nodiscard]] double RawNoiseScale(const StoredDepth& depth, int stride, const DepthNoise& noise);

}  // namespace deepslam::alignment
