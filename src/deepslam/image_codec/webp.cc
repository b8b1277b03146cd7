#include "deepslam/image_codec/webp.h"

#include <cstddef>
#include <cstdint>

#include <webp/decode.h>

namespace deepslam::image_codec {
namespace {

const std::uint8_t* Data(std::string_view bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

// The container's own word, behind its first eight bytes.
bool IsWhole(std::string_view bytes) {
  std::size_t length = 0;
  for (std::size_t i = 0; i < 4; ++i) length |= std::size_t{Data(bytes)[4 + i]} << 8 * i;
  return length <= bytes.size() - 8;
}

}  // namespace

ImageStructure WebpStructure(std::string_view bytes) {
  ImageStructure structure{.format = ImageFormat::kWebp};
  if (WebPGetInfo(Data(bytes), bytes.size(), &structure.width, &structure.height) == 0)
    return structure;
  structure.channels = 3;
  structure.bits = 8;
  structure.stored_bits = 24;
  structure.complete = IsWhole(bytes);
  return structure;
}

Result<ColourImage> DecodeWebp(std::string_view bytes) {
  const ImageStructure structure = StructureOf(bytes);
  if (structure.format != ImageFormat::kWebp) return InvalidInput("is no WebP image");
  if (const Status checked = CheckStructure(structure, bytes); !checked) return checked.error();
  ColourImage image(structure.width, structure.height);
  const bool decoded = WebPDecodeRGBInto(Data(bytes),
                                         bytes.size(),
                                         reinterpret_cast<std::uint8_t*>(image.data()),
                                         image.size() * sizeof(Rgb8),
                                         image.width() * static_cast<int>(sizeof(Rgb8))) != nullptr;
  if (!decoded) return InvalidInput("damaged WebP image, or an animation");
  return image;
}

}  // namespace deepslam::image_codec
