// TIFF of one sample a pixel, by libtiff: whole numbers of 16 bits, real ones of 32.
#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <tiffio.h>

#include "deepslam/image_codec/depth_formats.h"

namespace deepslam::image_codec {
namespace {

// The most that Deflate makes of a byte; LZW and PackBits make less.
constexpr std::size_t kMaxExpansion = 1032;
// Of one row or block; none of an image of 50 million pixels takes more.
constexpr tmsize_t kMaxBlockBytes = tmsize_t{256} << 20;

// Bytes as the file that libtiff reads, and what it says of them.
struct Source {
  std::string_view bytes;
  toff_t at = 0;
  std::string fault;
};

tmsize_t ReadBytes(thandle_t handle, void* to, tmsize_t count) {
  auto& source = *static_cast<Source*>(handle);
  if (count < 0 || source.at >= source.bytes.size()) return 0;
  const std::size_t taken =
      std::min<std::size_t>(static_cast<std::size_t>(count), source.bytes.size() - source.at);
  std::memcpy(to, source.bytes.data() + source.at, taken);
  source.at += taken;
  return static_cast<tmsize_t>(taken);
}

tmsize_t WriteNothing(thandle_t /*handle*/, void* /*from*/, tmsize_t /*count*/) { return 0; }

toff_t Seek(thandle_t handle, toff_t offset, int whence) {
  auto& source = *static_cast<Source*>(handle);
  if (whence == SEEK_SET) source.at = offset;
  if (whence == SEEK_CUR) source.at += offset;
  if (whence == SEEK_END) source.at = source.bytes.size() + offset;
  return source.at;
}

int CloseNothing(thandle_t /*handle*/) { return 0; }
toff_t SizeOf(thandle_t handle) { return static_cast<Source*>(handle)->bytes.size(); }

int NoteFault(
    TIFF* /*tiff*/, void* data, const char* /*module*/, const char* format, va_list arguments) {
  std::string& fault = static_cast<Source*>(data)->fault;
  if (!fault.empty()) return 1;
  char text[200];
  std::vsnprintf(text, sizeof text, format, arguments);
  fault = text;
  return 1;
}

int IgnoreWarning(TIFF* /*tiff*/,
                  void* /*data*/,
                  const char* /*module*/,
                  const char* /*format*/,
                  va_list /*arguments*/) {
  return 1;
}

struct Close {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using TiffPtr = std::unique_ptr<TIFF, Close>;

TiffPtr Open(Source& source) {
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
      TIFFOpenOptionsAlloc(), &TIFFOpenOptionsFree);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMaxBlockBytes);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), NoteFault, &source);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), IgnoreWarning, nullptr);
  return TiffPtr(TIFFClientOpenExt("",
                                   "rm",
                                   &source,
                                   ReadBytes,
                                   WriteNothing,
                                   Seek,
                                   CloseNothing,
                                   SizeOf,
                                   nullptr,
                                   nullptr,
                                   options.get()));
}

Error Damaged(const Source& source) {
  return InvalidInput(fmt::format("TIFF is damaged or ends too early ({})",
                                  source.fault.empty() ? "unreadable" : source.fault));
}

Result<DepthStructure> StructureOfOpen(TIFF& tiff, const Source& source) {
  std::uint32_t width = 0, height = 0;
  std::uint16_t bits = 0, samples = 1, kind = SAMPLEFORMAT_UINT;
  if (TIFFGetField(&tiff, TIFFTAG_IMAGEWIDTH, &width) != 1 ||
      TIFFGetField(&tiff, TIFFTAG_IMAGELENGTH, &height) != 1) {
    return Damaged(source);
  }
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
  TIFFGetFieldDefaulted(&tiff, TIFFTAG_SAMPLEFORMAT, &kind);
  const bool whole = bits == 16 && (kind == SAMPLEFORMAT_UINT || kind == SAMPLEFORMAT_VOID);
  const bool real = bits == 32 && kind == SAMPLEFORMAT_IEEEFP;
  if (samples != 1 || (!whole && !real)) {
    return InvalidInput(
        fmt::format("TIFF of {} channels of {} bits; depth is read as one of 16-bit whole or "
                    "32-bit real numbers",
                    samples,
                    bits));
  }
  if (const Status sane = CheckDepthSize(width, height, source.bytes.size(), kMaxExpansion); !sane)
    return sane.error();
  return DepthStructure{
      DepthFormat::kTiff, static_cast<int>(width), static_cast<int>(height), real};
}

template <typename T>
Status ReadRows(TIFF& tiff, const Source& source, Image<T>& image) {
  if (TIFFScanlineSize(&tiff) !=
      static_cast<tmsize_t>(sizeof(T) * static_cast<std::size_t>(image.width()))) {
    return Damaged(source);
  }
  for (int v = 0; v < image.height(); ++v) {
    if (TIFFReadScanline(&tiff, image.row(v), static_cast<std::uint32_t>(v)) != 1)
      return Damaged(source);
  }
  return Ok();
}

template <typename T>
Status ReadTiles(TIFF& tiff, const Source& source, Image<T>& image) {
  std::uint32_t wide = 0, high = 0;
  TIFFGetField(&tiff, TIFFTAG_TILEWIDTH, &wide);
  TIFFGetField(&tiff, TIFFTAG_TILELENGTH, &high);
  const tmsize_t size = TIFFTileSize(&tiff);
  if (wide == 0 || high == 0 || size <= 0 || size > kMaxBlockBytes ||
      static_cast<std::size_t>(size) != sizeof(T) * wide * high) {
    return Damaged(source);
  }
  std::vector<T> tile(static_cast<std::size_t>(wide) * high);
  for (std::uint32_t top = 0; top < static_cast<std::uint32_t>(image.height()); top += high) {
    for (std::uint32_t left = 0; left < static_cast<std::uint32_t>(image.width()); left += wide) {
      if (TIFFReadTile(&tiff, tile.data(), left, top, 0, 0) != size) return Damaged(source);
      const std::size_t columns =
          std::min<std::size_t>(wide, static_cast<std::size_t>(image.width()) - left);
      const std::size_t rows =
          std::min<std::size_t>(high, static_cast<std::size_t>(image.height()) - top);
      for (std::size_t row = 0; row < rows; ++row) {
        std::copy_n(tile.begin() + static_cast<std::ptrdiff_t>(row * wide),
                    columns,
                    image.row(static_cast<int>(top + row)) + left);
      }
    }
  }
  return Ok();
}

template <typename T>
Result<DepthPixels> Pixels(TIFF& tiff, const Source& source, const DepthStructure& structure) {
  Image<T> image(structure.width, structure.height);
  const Status read =
      TIFFIsTiled(&tiff) != 0 ? ReadTiles(tiff, source, image) : ReadRows(tiff, source, image);
  if (!read) return read.error();
  return DepthPixels(std::move(image));
}

}  // namespace

Result<DepthStructure> TiffStructure(std::string_view bytes) {
  Source source{bytes, 0, {}};
  const TiffPtr tiff = Open(source);
  if (!tiff) return Damaged(source);
  return StructureOfOpen(*tiff, source);
}

Result<DepthPixels> DecodeTiff(std::string_view bytes) {
  Source source{bytes, 0, {}};
  const TiffPtr tiff = Open(source);
  if (!tiff) return Damaged(source);
  const Result<DepthStructure> structure = StructureOfOpen(*tiff, source);
  if (!structure) return structure.error();
  return structure->real ? Pixels<float>(*tiff, source, *structure)
                         : Pixels<std::uint16_t>(*tiff, source, *structure);
}

}  // namespace deepslam::image_codec
