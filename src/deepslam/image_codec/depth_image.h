// Depth images in memory, whatever the file's name says: PNG, PGM, TIFF, OpenEXR and NumPy arrays,
// of whole numbers of 16 bits or of real ones. What a value stands for is the caller's to know.
//
// Bytes come from strangers: sizes are held against what the bytes can be before memory is taken.
#pragma once

#include <cstdint>
#include <string_view>
#include <variant>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"

namespace deepslam::image_codec {

enum class DepthFormat { kPng, kPgm, kTiff, kExr, kNpy, kOther };

// By the first bytes.
[[nodiscard]] DepthFormat DepthFormatOf(std::string_view bytes);

struct DepthStructure {
  DepthFormat format = DepthFormat::kOther;
  int width = 0;      // px
  int height = 0;     // px
  bool real = false;  // numbers with a point; else whole ones of at most 16 bits
};

// Of the file's header. Errors: none of these formats, no depth image (channels, bits), damage.
[[nodiscard]] Result<DepthStructure> DepthStructureOf(std::string_view bytes);

// Whole numbers beyond 16 bits (NumPy's 32 and 64) become 0, as do those below 0. Real ones stay as
// they are, infinities and nan included.
using DepthPixels = std::variant<Image<std::uint16_t>, Image<float>>;
[[nodiscard]] Result<DepthPixels> DecodeDepth(std::string_view bytes);

}  // namespace deepslam::image_codec
