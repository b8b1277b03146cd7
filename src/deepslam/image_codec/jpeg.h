// JPEG images in memory, baseline and progressive, by libjpeg-turbo. Rotation tags and colour
// profiles are left alone, since intrinsics belong to the stored pixels. Errors: what
// CheckStructure refuses, and damage that leaves no picture.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"

namespace deepslam::image_codec {

// Grey images become colours; four channels are taken as Adobe's inverted CMYK.
[[nodiscard]] Result<ColourImage> DecodeJpegColour(std::string_view bytes);

// Intensity alone, decoded at 1/reduction of the size: 1, 2, 4 or 8, of which both sides are
// multiples. Not of four channels.
[[nodiscard]] Result<Image<std::uint8_t>> DecodeJpegGrey(std::string_view bytes, int reduction = 1);

// Baseline, colours at half the resolution. quality: 1 to 100.
[[nodiscard]] Result<std::string> EncodeJpeg(const ColourImage& image, int quality);

}  // namespace deepslam::image_codec
