// PNG images in memory, by libpng. Pixels are taken as they are stored: no gamma, no colour
// profile. Errors: what CheckStructure refuses, and damage.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"

namespace deepslam::image_codec {

// Grey levels and palettes become colours, of 16 bits the upper 8 are taken, transparency is left
// out.
[[nodiscard]] Result<ColourImage> DecodePngColour(std::string_view bytes);
// Grey images of up to 8 bits; fewer are stretched to 0 ... 255. Others are errors.
[[nodiscard]] Result<Image<std::uint8_t>> DecodePngGrey(std::string_view bytes);
// Grey images of 16 bits. Others are errors.
[[nodiscard]] Result<Image<std::uint16_t>> DecodePngGrey16(std::string_view bytes);

// Real numbers of 32 bits whose bytes were written as the channels blue, green, red and alpha, as
// OpenCV's users do who have no other place for them. Other images are errors.
[[nodiscard]] Result<Image<float>> DecodePngFloat(std::string_view bytes);

[[nodiscard]] Result<std::string> EncodePng(const ColourImage& image);
[[nodiscard]] Result<std::string> EncodePng(const Image<std::uint16_t>& image);

}  // namespace deepslam::image_codec
