// Brightness of colour images: luma, 0.299 R + 0.587 G + 0.114 B in steps of 1/256.
#pragma once

#include "deepslam/core/image.h"

namespace deepslam {

// Averaged over blocks of factor x factor pixels; columns and rows at the end that fill no block
// are left out.
[[nodiscard]] BrightnessImage BrightnessOf(const ColourImage& colour, int factor);

// The same of an image that is brightness already.
[[nodiscard]] BrightnessImage ReducedBrightness(const BrightnessImage& brightness, int factor);

}  // namespace deepslam
