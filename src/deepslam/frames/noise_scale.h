// How noisy measured depth is.
#pragma once

#include <span>

#include "deepslam/frames/stored_depth.h"
#include "deepslam/geometry/depth_noise.h"

namespace deepslam {

// Noise is measured between 1 and this many times the model's: beyond, depth says nothing.
inline constexpr double kMaxNoiseScale = 8.0;

// More noise than this was measured for sure; less may as well be the scene's own relief.
inline constexpr double kSureNoiseScale = 1.5;

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

}  // namespace deepslam
