// Colours out of an image in memory, by its own first bytes: png.h, jpeg.h and webp.h in one.
#pragma once

#include <string_view>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"

namespace deepslam::image_codec {

[[nodiscard]] Result<ColourImage> DecodeColour(std::string_view bytes);

}  // namespace deepslam::image_codec
