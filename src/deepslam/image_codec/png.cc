#include "deepslam/image_codec/png.h"

#include <array>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <vector>

#include <fmt/format.h>
#include <png.h>
#include <zlib.h>

#include "deepslam/image_codec/structure.h"

namespace deepslam::image_codec {
namespace {

constexpr int kCompressionLevel = 3;  // of 9: beyond, images shrink by little and take far longer

enum class Pixels { kRgb8, kGrey8, kGrey16, kBgra8 };

using Fault = std::array<char, 128>;

struct PngReader {
  std::string_view rest;
  Fault fault{};
  png_structp png = nullptr;
  png_infop info = nullptr;

  PngReader() = default;
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

struct PngWriter {
  std::string bytes;
  Fault fault{};
  png_structp png = nullptr;
  png_infop info = nullptr;

  PngWriter() = default;
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
};

[[noreturn]] void Leave(png_structp png, png_const_charp message) {
  auto* const fault = static_cast<Fault*>(png_get_error_ptr(png));
  std::snprintf(fault->data(), fault->size(), "%s", message);
  png_longjmp(png, 1);
}

void KeepQuiet(png_structp, png_const_charp) {}

void ReadBytes(png_structp png, png_bytep to, std::size_t count) {
  std::string_view& rest = static_cast<PngReader*>(png_get_io_ptr(png))->rest;
  if (count > rest.size()) png_error(png, "ends too early");
  std::memcpy(to, rest.data(), count);
  rest.remove_prefix(count);
}

void WriteBytes(png_structp png, png_bytep from, std::size_t count) {
  static_cast<PngWriter*>(png_get_io_ptr(png))
      ->bytes.append(reinterpret_cast<const char*>(from), count);
}

void Flush(png_structp) {}

void AskFor(Pixels wanted, png_structp png, png_infop info) {
  const int type = png_get_color_type(png, info);
  const int bits = png_get_bit_depth(png, info);
  if (wanted == Pixels::kBgra8) {
    png_set_bgr(png);
    return;
  }
  png_set_strip_alpha(png);
  if (wanted == Pixels::kGrey16) {
    png_set_swap(png);
    return;
  }
  if (bits == 16) png_set_strip_16(png);
  if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (type == PNG_COLOR_TYPE_GRAY && bits < 8) png_set_expand_gray_1_2_4_to_8(png);
  if (wanted == Pixels::kRgb8 && (type & PNG_COLOR_MASK_COLOR) == 0) png_set_gray_to_rgb(png);
}

// libpng leaves its functions by longjmp, past destructors: nothing in this one has any.
bool ReadRows(PngReader& reader,
              Pixels wanted,
              std::vector<png_bytep>& rows,
              std::size_t row_bytes) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_set_read_fn(reader.png, &reader, ReadBytes);
  png_read_info(reader.png, reader.info);
  AskFor(wanted, reader.png, reader.info);
  png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  if (png_get_image_height(reader.png, reader.info) != rows.size() ||
      png_get_rowbytes(reader.png, reader.info) != row_bytes)
    png_error(reader.png, "its header is damaged");
  png_read_image(reader.png, rows.data());
  png_read_end(reader.png, nullptr);
  return true;
}

template <typename Pixel>
std::vector<png_bytep> RowsOf(Image<Pixel>& image) {
  std::vector<png_bytep> rows;
  for (int v = 0; v < image.height(); ++v)
    rows.push_back(reinterpret_cast<png_bytep>(image.row(v)));
  return rows;
}

template <typename Pixel>
Result<Image<Pixel>> Decode(std::string_view bytes,
                            const ImageStructure& structure,
                            Pixels wanted) {
  PngReader reader;
  reader.rest = bytes;
  reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader.fault, Leave, KeepQuiet);
  if (reader.png != nullptr) reader.info = png_create_info_struct(reader.png);
  if (reader.info == nullptr) return Failed("no memory to read a PNG image");
  Image<Pixel> image(structure.width, structure.height);
  std::vector<png_bytep> rows = RowsOf(image);
  if (!ReadRows(reader, wanted, rows, static_cast<std::size_t>(image.width()) * sizeof(Pixel)))
    return InvalidInput(fmt::format("damaged PNG image ({})", reader.fault.data()));
  return image;
}

Status CheckPng(const ImageStructure& structure, std::string_view bytes) {
  if (structure.format != ImageFormat::kPng) return InvalidInput("is no PNG image");
  return CheckStructure(structure, bytes);
}

// With what the pixels must be.
template <typename Pixel>
Result<Image<Pixel>> DecodeGreyOf(std::string_view bytes, int bits, Pixels wanted) {
  const ImageStructure structure = StructureOf(bytes);
  if (const Status checked = CheckPng(structure, bytes); !checked) return checked.error();
  if (structure.channels != 1 || structure.bits != bits) {
    return InvalidInput(fmt::format("must have one channel of {} bits, this has {} of {} bits",
                                    bits,
                                    structure.channels,
                                    structure.bits));
  }
  return Decode<Pixel>(bytes, structure, wanted);
}

// See ReadRows.
bool WriteRows(PngWriter& writer,
               const std::vector<png_const_bytep>& rows,
               int width,
               Pixels pixels) {
  if (setjmp(png_jmpbuf(writer.png)) != 0) return false;
  png_set_write_fn(writer.png, &writer, WriteBytes, Flush);
  png_set_compression_level(writer.png, kCompressionLevel);
  png_set_compression_strategy(writer.png, Z_DEFAULT_STRATEGY);
  png_set_IHDR(writer.png,
               writer.info,
               static_cast<png_uint_32>(width),
               static_cast<png_uint_32>(rows.size()),
               pixels == Pixels::kGrey16 ? 16 : 8,
               pixels == Pixels::kRgb8 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(writer.png, writer.info);
  if (pixels == Pixels::kGrey16) png_set_swap(writer.png);
  for (std::size_t v = 0; v < rows.size(); ++v) png_write_row(writer.png, rows[v]);
  png_write_end(writer.png, writer.info);
  return true;
}

template <typename Pixel>
Result<std::string> Encode(const Image<Pixel>& image, Pixels pixels) {
  PngWriter writer;
  writer.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &writer.fault, Leave, KeepQuiet);
  if (writer.png != nullptr) writer.info = png_create_info_struct(writer.png);
  if (writer.info == nullptr) return Failed("no memory to write a PNG image");
  std::vector<png_const_bytep> rows;
  for (int v = 0; v < image.height(); ++v)
    rows.push_back(reinterpret_cast<png_const_bytep>(image.row(v)));
  if (!WriteRows(writer, rows, image.width(), pixels))
    return Failed(fmt::format("cannot encode the image as PNG ({})", writer.fault.data()));
  return std::move(writer.bytes);
}

}  // namespace

Result<ColourImage> DecodePngColour(std::string_view bytes) {
  const ImageStructure structure = StructureOf(bytes);
  if (const Status checked = CheckPng(structure, bytes); !checked) return checked.error();
  return Decode<Rgb8>(bytes, structure, Pixels::kRgb8);
}

Result<Image<std::uint8_t>> DecodePngGrey(std::string_view bytes) {
  return DecodeGreyOf<std::uint8_t>(bytes, 8, Pixels::kGrey8);
}

Result<Image<float>> DecodePngFloat(std::string_view bytes) {
  const ImageStructure structure = StructureOf(bytes);
  if (const Status checked = CheckPng(structure, bytes); !checked) return checked.error();
  if (structure.channels != 4 || structure.bits != 8 || structure.stored_bits != 32) {
    return InvalidInput(fmt::format("must have four channels of 8 bits, this has {} of {} bits",
                                    structure.channels,
                                    structure.bits));
  }
  return Decode<float>(bytes, structure, Pixels::kBgra8);
}

Result<Image<std::uint16_t>> DecodePngGrey16(std::string_view bytes) {
  return DecodeGreyOf<std::uint16_t>(bytes, 16, Pixels::kGrey16);
}

Result<std::string> EncodePng(const ColourImage& image) { return Encode(image, Pixels::kRgb8); }

Result<std::string> EncodePng(const Image<std::uint16_t>& image) {
  return Encode(image, Pixels::kGrey16);
}

}  // namespace deepslam::image_codec
