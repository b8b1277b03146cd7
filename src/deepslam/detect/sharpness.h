// How far a picture is from being blurred by the camera's motion: what a detector misses in one
// frame it often finds in the next.
#pragma once

#include "deepslam/core/image.h"

namespace deepslam::detect {

// Mean square of the Laplacian (Pech-Pacheco et al. 2000): comparable between pictures of one scene
// by one camera. 0 of pictures of less than 3 x 3 pixels.
[[nodiscard]] double Sharpness(const IntensityImage& intensity);

}  // namespace deepslam::detect
