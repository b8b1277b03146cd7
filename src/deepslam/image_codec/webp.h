// WebP images in memory, by libwebp: textures of furniture in glTF (EXT_texture_webp). Captures
// have none.
#pragma once

#include <string_view>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/image_codec/structure.h"

namespace deepslam::image_codec {

// For StructureOf, which knows the other formats by itself.
[[nodiscard]] ImageStructure WebpStructure(std::string_view bytes);

// Transparency is left out. Errors: what CheckStructure refuses, damage, animations.
[[nodiscard]] Result<ColourImage> DecodeWebp(std::string_view bytes);

}  // namespace deepslam::image_codec
