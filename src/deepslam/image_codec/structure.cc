#include "deepslam/image_codec/structure.h"

#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

#include "deepslam/image_codec/webp.h"

namespace deepslam::image_codec {
namespace {

constexpr std::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);
// The most that Deflate makes of a byte; JPEG's shortest codes reach no more than half of it.
constexpr std::size_t kMaxExpansion = 1032;
// More than any camera and any texture has; WebP packs a picture of one colour into some 50 bytes.
constexpr std::size_t kMaxPixels = 50'000'000;

std::uint32_t BigEndian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  }
  return value;
}

void ReadPngHeader(std::string_view chunk, ImageStructure& structure) {
  structure.width = static_cast<int>(BigEndian(chunk, 0, 4) & 0x7FFFFFFF);
  structure.height = static_cast<int>(BigEndian(chunk, 4, 4) & 0x7FFFFFFF);
  const int depth = static_cast<unsigned char>(chunk[8]);
  const int type = static_cast<unsigned char>(chunk[9]);
  const bool palette = (type & 1) != 0, colour = (type & 2) != 0, alpha = (type & 4) != 0;
  structure.channels = (colour ? 3 : 1) + (alpha ? 1 : 0);
  structure.bits = depth == 16 ? 16 : 8;
  structure.stored_bits = palette ? depth : depth * structure.channels;
}

ImageStructure PngStructure(std::string_view bytes) {
  ImageStructure structure{.format = ImageFormat::kPng};
  std::size_t at = kPngSignature.size();
  while (bytes.size() >= at + 12) {
    const std::size_t length = BigEndian(bytes, at, 4);
    const std::string_view type = bytes.substr(at + 4, 4);
    if (bytes.size() - at - 12 < length) break;
    if (type == "IHDR" && length >= 10 && structure.width == 0)  // decoders take the first
      ReadPngHeader(bytes.substr(at + 8, length), structure);
    if (type == "IEND") {
      structure.complete = true;
      break;
    }
    at += 12 + length;
  }
  return structure;
}

bool IsFrameHeader(unsigned char marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

void ReadJpegHeader(std::string_view segment, ImageStructure& structure) {
  structure.height = static_cast<int>(BigEndian(segment, 1, 2));
  structure.width = static_cast<int>(BigEndian(segment, 3, 2));
  structure.channels = static_cast<unsigned char>(segment[5]);
  structure.bits = 8;
  structure.stored_bits = 8;  // the least, of grey ones
}

// Where the coded pixels at `at` end: before the next marker, none of those that only restart them.
// 0xFF stands before a 0 among them, and before itself where a marker follows.
std::size_t EndOfPixels(std::string_view bytes, std::size_t at) {
  while (true) {
    at = bytes.find('\xFF', at);
    if (at == std::string_view::npos || at + 1 >= bytes.size()) return bytes.size();
    const auto next = static_cast<unsigned char>(bytes[at + 1]);
    if (next != 0 && (next < 0xD0 || next > 0xD7)) return at;
    at += 2;
  }
}

ImageStructure JpegStructure(std::string_view bytes) {
  ImageStructure structure{.format = ImageFormat::kJpeg};
  std::size_t at = 2;
  while (at + 2 <= bytes.size()) {
    if (bytes[at] != '\xFF') break;
    const auto marker = static_cast<unsigned char>(bytes[at + 1]);
    if (marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    if (marker == 0xD9) {
      structure.complete = true;
      break;
    }
    if (at + 4 > bytes.size()) break;
    const std::size_t length = BigEndian(bytes, at + 2, 2);
    if (at + 2 + length > bytes.size()) break;
    if (IsFrameHeader(marker) && length >= 8)
      ReadJpegHeader(bytes.substr(at + 4, length - 2), structure);
    at += 2 + length;
    if (marker == 0xDA) at = EndOfPixels(bytes, at);
  }
  return structure;
}

}  // namespace

ImageFormat FormatOf(std::string_view bytes) {
  if (bytes.starts_with(kPngSignature)) return ImageFormat::kPng;
  if (bytes.starts_with("\xFF\xD8\xFF")) return ImageFormat::kJpeg;
  if (bytes.starts_with("RIFF") && bytes.size() >= 12 && bytes.substr(8, 4) == "WEBP")
    return ImageFormat::kWebp;
  return ImageFormat::kOther;
}

ImageStructure StructureOf(std::string_view bytes) {
  switch (FormatOf(bytes)) {
    case ImageFormat::kPng:
      return PngStructure(bytes);
    case ImageFormat::kJpeg:
      return JpegStructure(bytes);
    case ImageFormat::kWebp:
      return WebpStructure(bytes);
    case ImageFormat::kOther:
      break;
  }
  return {};
}

Status CheckStructure(const ImageStructure& structure, std::string_view bytes) {
  if (structure.format == ImageFormat::kOther) return InvalidInput("is no PNG, JPEG or WebP image");
  if (!structure.complete || structure.width < 1 || structure.height < 1)
    return InvalidInput("image file ends too early (truncated or damaged)");
  const std::size_t num_pixels =
      static_cast<std::size_t>(structure.width) * static_cast<std::size_t>(structure.height);
  const std::size_t held = 8 * kMaxExpansion * bytes.size();
  const bool packed_too_well = structure.format != ImageFormat::kWebp &&
                               num_pixels * static_cast<std::size_t>(structure.stored_bits) > held;
  if (packed_too_well) {
    return InvalidInput(fmt::format(
        "has {} bytes, too few for {} x {} px", bytes.size(), structure.width, structure.height));
  }
  if (num_pixels > kMaxPixels) {
    return InvalidInput(fmt::format("has {} x {} px, more than {}: make it smaller",
                                    structure.width,
                                    structure.height,
                                    kMaxPixels));
  }
  return Ok();
}

}  // namespace deepslam::image_codec
