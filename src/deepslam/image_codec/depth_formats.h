// The formats behind depth_image.h, one file each. Each takes bytes that begin as the format does.
#pragma once

#include <cstddef>

#include "deepslam/image_codec/depth_image.h"

namespace deepslam::image_codec {

[[nodiscard]] Result<DepthStructure> PgmStructure(std::string_view bytes);
[[nodiscard]] Result<DepthPixels> DecodePgm(std::string_view bytes);

[[nodiscard]] Result<DepthStructure> NpyStructure(std::string_view bytes);
[[nodiscard]] Result<DepthPixels> DecodeNpy(std::string_view bytes);

[[nodiscard]] Result<DepthStructure> TiffStructure(std::string_view bytes);
[[nodiscard]] Result<DepthPixels> DecodeTiff(std::string_view bytes);

[[nodiscard]] Result<DepthStructure> ExrStructure(std::string_view bytes);
[[nodiscard]] Result<DepthPixels> DecodeExr(std::string_view bytes);

// Refuses sizes that no camera has, and those that `num_bytes` could not hold at `expansion` pixels
// a byte.
[[nodiscard]] Status CheckDepthSize(std::int64_t width,
                                    std::int64_t height,
                                    std::size_t num_bytes,
                                    std::size_t expansion);

}  // namespace deepslam::image_codec
