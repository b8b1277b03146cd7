// Masks as COCO run-length strings (the compressed `counts` of pycocotools): column-major runs,
// zeros first.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"

namespace deepslam {

// Largest mask that is decoded, pixels: a hostile file must not allocate without bound.
inline constexpr int kMaxMaskPixels = 1 << 26;

// The one text of the mask: no run but the first is empty.
[[nodiscard]] std::string EncodeRle(const Mask& mask);

// The text of runs given as numbers (COCO's uncompressed `counts`): not negative, of width x height
// pixels in all. Refuses others, and what DecodeRle refuses.
[[nodiscard]] Result<std::string> RleOfRuns(std::span<const std::int64_t> runs,
                                            int width,
                                            int height);

// Refuses counts that do not fill width x height exactly, characters outside the code, sizes beyond
// kMaxMaskPixels. The message does not name the file: the caller does.
[[nodiscard]] Result<Mask> DecodeRle(std::string_view counts, int width, int height);

// The one text of the mask whose counts these are, which may hold empty runs; refuses the same.
[[nodiscard]] Result<std::string> CanonicalRle(std::string_view counts, int width, int height);

// The same mask at another size, each pixel with the value that lies under its centre. Takes the
// memory of the result, whatever the mask's own size.
[[nodiscard]] Result<Mask> DecodeRleResized(
    std::string_view counts, int width, int height, int out_width, int out_height);

}  // namespace deepslam
