// What other frames are aligned to: each texel's tangent plane, and its brightness with
// derivatives. Keyframes alone need them, of every texel; a frame that is aligned brings a few rows
// (SourcePoints).
#pragma once

#include <cstddef>

#include "deepslam/alignment/image_pyramid.h"

namespace deepslam::alignment {

[[nodiscard]] bool IsReference(const FramePyramid& pyramid);

// The same with texels on all levels.
[[nodiscard]] FramePyramid AsReference(FramePyramid pyramid);

// The texel has no depth any more and, on a target's level, no surface that others could find.
void HidePixel(std::size_t texel, PyramidLevel& level);

[[nodiscard]] UnfilledVector<IntensityTexel> WithDerivatives(const BrightnessImage& image);

}  // namespace deepslam::alignment
