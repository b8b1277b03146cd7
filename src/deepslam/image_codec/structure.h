// What an image file in memory is by its own structure, found before any pixel is decoded: decoders
// fill the rest of a truncated JPEG with grey, and allocate whatever size a header claims.
#pragma once

#include <string_view>

#include "deepslam/core/result.h"

namespace deepslam::image_codec {

enum class ImageFormat { kPng, kJpeg, kWebp, kOther };

// By the first bytes, whatever the file's name says.
[[nodiscard]] ImageFormat FormatOf(std::string_view bytes);

struct ImageStructure {
  ImageFormat format = ImageFormat::kOther;
  int width = 0;        // px; 0: no header was found
  int height = 0;       // px
  int channels = 0;     // of decoded pixels: 3 of a palette
  int bits = 0;         // per channel of decoded pixels: 8 or 16
  int stored_bits = 0;  // per pixel, before compression
  bool complete = false;
};

[[nodiscard]] ImageStructure StructureOf(std::string_view bytes);

// An error of a format that is none of these, of a file that ends too early, and of one that claims
// more pixels than its bytes can hold.
[[nodiscard]] Status CheckStructure(const ImageStructure& structure, std::string_view bytes);

}  // namespace deepslam::image_codec
