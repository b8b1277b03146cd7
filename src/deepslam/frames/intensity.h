// Intensity of colour images: luma, 0.299 R + 0.587 G + 0.114 B in steps of 1/256.
#pragma once

#include "deepslam/core/image.h"

namespace deepslam {

// Averaged over blocks of factor x factor pixels; columns and rows at the end that fill no block
// are left out.
[[nodiscard]] IntensityImage IntensityOf(const ColourImage& colour, int factor);

// The same of an image that is intensity already.
[[nodiscard]] IntensityImage ReducedIntensity(const IntensityImage& intensity, int factor);

}  // namespace deepslam
