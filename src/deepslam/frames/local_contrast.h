// Local contrast normalisation: an image less its local mean, by its local deviation.
#pragma once

#include "deepslam/core/image.h"

namespace deepslam {

// Over windows of 7 x 7 pixels, smaller ones at the border. Near 0 where there is no contrast.
[[nodiscard]] Image<float> NormaliseLocalContrast(const Image<float>& image);

}  // namespace deepslam
