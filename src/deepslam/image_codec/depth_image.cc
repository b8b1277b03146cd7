#include "deepslam/image_codec/depth_image.h"

#include <fmt/format.h>

#include "deepslam/image_codec/depth_formats.h"
#include "deepslam/image_codec/png.h"
#include "deepslam/image_codec/structure.h"

namespace deepslam::image_codec {
namespace {

// More than any depth camera has.
constexpr std::int64_t kMaxPixels = 50'000'000;

Result<DepthStructure> PngDepthStructure(std::string_view bytes) {
  const ImageStructure structure = StructureOf(bytes);
  if (const Status whole = CheckStructure(structure, bytes); !whole) return whole.error();
  if (structure.channels != 1 || structure.bits != 16) {
    return InvalidInput(
        fmt::format("depth must have one channel of 16 bits, this has {} of {} bits",
                    structure.channels,
                    structure.bits));
  }
  return DepthStructure{DepthFormat::kPng, structure.width, structure.height, false};
}

Result<DepthPixels> DecodePngDepth(std::string_view bytes) {
  Result<Image<std::uint16_t>> pixels = DecodePngGrey16(bytes);
  if (!pixels) return pixels.error();
  return DepthPixels(*std::move(pixels));
}

}  // namespace

Status CheckDepthSize(std::int64_t width,
                      std::int64_t height,
                      std::size_t num_bytes,
                      std::size_t expansion) {
  if (width < 1 || height < 1 || width > kMaxPixels || height > kMaxPixels ||
      width * height > kMaxPixels) {
    return InvalidInput(
        fmt::format("has {} x {} px, a depth image 1 to {}", width, height, kMaxPixels));
  }
  if (static_cast<std::size_t>(width * height) / expansion > num_bytes) {
    return InvalidInput(
        fmt::format("has {} bytes, too few for {} x {} px (truncated?)", num_bytes, width, height));
  }
  return Ok();
}

DepthFormat DepthFormatOf(std::string_view bytes) {
  if (FormatOf(bytes) == ImageFormat::kPng) return DepthFormat::kPng;
  if (bytes.starts_with("P5")) return DepthFormat::kPgm;
  if (bytes.starts_with(std::string_view("II*\0", 4)) ||
      bytes.starts_with(std::string_view("MM\0*", 4))) {
    return DepthFormat::kTiff;
  }
  if (bytes.starts_with("\x76\x2f\x31\x01")) return DepthFormat::kExr;
  if (bytes.starts_with("\x93NUMPY")) return DepthFormat::kNpy;
  return DepthFormat::kOther;
}

Result<DepthStructure> DepthStructureOf(std::string_view bytes) {
  switch (DepthFormatOf(bytes)) {
    case DepthFormat::kPng:
      return PngDepthStructure(bytes);
    case DepthFormat::kPgm:
      return PgmStructure(bytes);
    case DepthFormat::kTiff:
      return TiffStructure(bytes);
    case DepthFormat::kExr:
      return ExrStructure(bytes);
    case DepthFormat::kNpy:
      return NpyStructure(bytes);
    case DepthFormat::kOther:
      break;
  }
  return InvalidInput(
      "is no depth image that is read here (PNG, PGM or TIFF of 16 bits, OpenEXR, NumPy's .npy)");
}

Result<DepthPixels> DecodeDepth(std::string_view bytes) {
  switch (DepthFormatOf(bytes)) {
    case DepthFormat::kPng:
      return DecodePngDepth(bytes);
    case DepthFormat::kPgm:
      return DecodePgm(bytes);
    case DepthFormat::kTiff:
      return DecodeTiff(bytes);
    case DepthFormat::kExr:
      return DecodeExr(bytes);
    case DepthFormat::kNpy:
      return DecodeNpy(bytes);
    case DepthFormat::kOther:
      break;
  }
  const Result<DepthStructure> refused = DepthStructureOf(bytes);
  return refused.error();
}

}  // namespace deepslam::image_codec
