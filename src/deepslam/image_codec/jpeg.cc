#include "deepslam/image_codec/jpeg.h"

#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>  // jpeglib.h needs it
#include <utility>

#include <fmt/format.h>
#include <jpeglib.h>

#include "deepslam/core/check.h"
#include "deepslam/image_codec/structure.h"

namespace deepslam::image_codec {
namespace {

// Progressive files of thousands of scans, each over the whole image, are made to keep decoders
// busy; cameras write a dozen.
constexpr int kMaxScans = 500;

struct Cmyk8 {
  std::uint8_t c, m, y, k;
};

// Where libjpeg goes with an error, and its words.
struct Errors {
  jpeg_error_mgr manager{};
  std::jmp_buf leave{};
  std::array<char, JMSG_LENGTH_MAX> fault{};
};

struct JpegReader {
  jpeg_decompress_struct info{};
  Errors errors;
  jpeg_source_mgr source{};
  jpeg_progress_mgr progress{};

  JpegReader() = default;
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
  ~JpegReader() { jpeg_destroy_decompress(&info); }
};

struct Destination {
  jpeg_destination_mgr manager{};  // first: libjpeg hands out its address
  std::array<JOCTET, 16384> part{};
  std::string bytes;
};

struct JpegWriter {
  jpeg_compress_struct info{};
  Errors errors;
  Destination destination;

  JpegWriter() = default;
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;
  ~JpegWriter() { jpeg_destroy_compress(&info); }
};

// What the pixels shall be, and where.
struct Pixels {
  J_COLOR_SPACE colour_space;
  int bytes_per_pixel;
  int reduction;
  int width;   // px, reduced
  int height;  // px, reduced
  unsigned char* data;
};

[[noreturn]] void Leave(j_common_ptr info) {
  auto* const errors = static_cast<Errors*>(info->client_data);
  info->err->format_message(info, errors->fault.data());
  std::longjmp(errors->leave, 1);
}

[[noreturn]] void LeaveSaying(std::string_view fault, jpeg_decompress_struct& info) {
  auto* const errors = static_cast<Errors*>(info.client_data);
  fault.copy(errors->fault.data(), errors->fault.size() - 1);
  std::longjmp(errors->leave, 1);
}

// Warnings are of damage within the coded pixels, behind which decoding goes on.
void KeepQuiet(j_common_ptr, int) {}

jpeg_error_mgr* LeaveOnErrors(Errors& errors) {
  jpeg_error_mgr* const manager = jpeg_std_error(&errors.manager);
  manager->error_exit = Leave;
  manager->emit_message = KeepQuiet;
  return manager;
}

void StartReading(j_decompress_ptr) {}
boolean FindNoMore(j_decompress_ptr info) { LeaveSaying("ends too early", *info); }
void Skip(j_decompress_ptr info, long count) {
  jpeg_source_mgr& source = *info->src;
  if (count <= 0) return;
  if (static_cast<unsigned long>(count) > source.bytes_in_buffer) FindNoMore(info);
  source.next_input_byte += count;
  source.bytes_in_buffer -= static_cast<std::size_t>(count);
}

void CountScans(j_common_ptr common) {
  auto& info = *reinterpret_cast<j_decompress_ptr>(common);
  if (info.input_scan_number > kMaxScans) LeaveSaying("has too many scans", info);
}

void ReadFrom(std::string_view bytes, JpegReader& reader) {
  jpeg_source_mgr& source = reader.source;
  source.init_source = StartReading;
  source.fill_input_buffer = FindNoMore;
  source.skip_input_data = Skip;
  source.resync_to_restart = jpeg_resync_to_restart;
  source.term_source = StartReading;
  source.next_input_byte = reinterpret_cast<const JOCTET*>(bytes.data());
  source.bytes_in_buffer = bytes.size();
  reader.info.src = &source;
  reader.progress.progress_monitor = CountScans;
  reader.info.progress = &reader.progress;
}

// libjpeg leaves its functions by longjmp, past destructors: nothing in this one has any.
bool ReadPixels(std::string_view bytes, JpegReader& reader, const Pixels& pixels) {
  jpeg_decompress_struct& info = reader.info;
  info.err = LeaveOnErrors(reader.errors);
  info.client_data = &reader.errors;
  if (setjmp(reader.errors.leave) != 0) return false;
  jpeg_create_decompress(&info);
  ReadFrom(bytes, reader);
  jpeg_read_header(&info, TRUE);
  info.out_color_space = pixels.colour_space;
  info.scale_num = 1;
  info.scale_denom = static_cast<unsigned>(pixels.reduction);
  info.dct_method = JDCT_ISLOW;
  jpeg_start_decompress(&info);
  if (info.output_width != static_cast<JDIMENSION>(pixels.width) ||
      info.output_height != static_cast<JDIMENSION>(pixels.height) ||
      info.output_components != pixels.bytes_per_pixel)
    LeaveSaying("its header is damaged", info);
  const std::size_t row_bytes =
      static_cast<std::size_t>(pixels.width) * static_cast<std::size_t>(pixels.bytes_per_pixel);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = pixels.data + info.output_scanline * row_bytes;
    jpeg_read_scanlines(&info, &row, 1);
  }
  return true;
}

template <typename Pixel>
Result<Image<Pixel>> Decode(std::string_view bytes,
                            const ImageStructure& structure,
                            J_COLOR_SPACE colour_space,
                            int reduction = 1) {
  Image<Pixel> image(structure.width / reduction, structure.height / reduction);
  const Pixels pixels = {colour_space,
                         static_cast<int>(sizeof(Pixel)),
                         reduction,
                         image.width(),
                         image.height(),
                         reinterpret_cast<unsigned char*>(image.data())};
  JpegReader reader;
  if (ReadPixels(bytes, reader, pixels)) return image;
  return InvalidInput(fmt::format("damaged JPEG image ({})", reader.errors.fault.data()));
}

Status CheckJpeg(const ImageStructure& structure, std::string_view bytes) {
  if (structure.format != ImageFormat::kJpeg) return InvalidInput("is no JPEG image");
  return CheckStructure(structure, bytes);
}

Rgb8 ToRgb(const Cmyk8& ink) {
  const auto shade = [&](int value) {
    return static_cast<std::uint8_t>(ink.k - (((255 - value) * ink.k) >> 8));
  };
  return {shade(ink.c), shade(ink.m), shade(ink.y)};
}

Result<ColourImage> DecodeCmyk(std::string_view bytes, const ImageStructure& structure) {
  const Result<Image<Cmyk8>> inks = Decode<Cmyk8>(bytes, structure, JCS_CMYK);
  if (!inks) return inks.error();
  ColourImage image(inks->width(), inks->height());
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = ToRgb(inks->data()[i]);
  return image;
}

void StartPart(j_compress_ptr info) {
  Destination& to = *reinterpret_cast<Destination*>(info->dest);
  to.manager.next_output_byte = to.part.data();
  to.manager.free_in_buffer = to.part.size();
}

boolean KeepPart(j_compress_ptr info) {
  Destination& to = *reinterpret_cast<Destination*>(info->dest);
  to.bytes.append(reinterpret_cast<const char*>(to.part.data()), to.part.size());
  StartPart(info);
  return TRUE;
}

void KeepLastPart(j_compress_ptr info) {
  Destination& to = *reinterpret_cast<Destination*>(info->dest);
  to.bytes.append(reinterpret_cast<const char*>(to.part.data()),
                  to.part.size() - to.manager.free_in_buffer);
}

void WriteInto(Destination& destination, jpeg_compress_struct& info) {
  destination.manager.init_destination = StartPart;
  destination.manager.empty_output_buffer = KeepPart;
  destination.manager.term_destination = KeepLastPart;
  info.dest = &destination.manager;
}

// See ReadPixels.
bool WritePixels(JpegWriter& writer, const ColourImage& image, int quality) {
  jpeg_compress_struct& info = writer.info;
  info.err = LeaveOnErrors(writer.errors);
  info.client_data = &writer.errors;
  if (setjmp(writer.errors.leave) != 0) return false;
  jpeg_create_compress(&info);
  WriteInto(writer.destination, info);
  info.image_width = static_cast<JDIMENSION>(image.width());
  info.image_height = static_cast<JDIMENSION>(image.height());
  info.input_components = 3;
  info.in_color_space = JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, quality, TRUE);
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) {
    const Rgb8* const row = image.row(static_cast<int>(info.next_scanline));
    JSAMPROW samples = const_cast<JSAMPROW>(reinterpret_cast<const JSAMPLE*>(row));
    jpeg_write_scanlines(&info, &samples, 1);
  }
  jpeg_finish_compress(&info);
  return true;
}

}  // namespace

Result<ColourImage> DecodeJpegColour(std::string_view bytes) {
  const ImageStructure structure = StructureOf(bytes);
  if (const Status checked = CheckJpeg(structure, bytes); !checked) return checked.error();
  if (structure.channels == 4) return DecodeCmyk(bytes, structure);
  return Decode<Rgb8>(bytes, structure, JCS_RGB);
}

Result<Image<std::uint8_t>> DecodeJpegGrey(std::string_view bytes, int reduction) {
  const ImageStructure structure = StructureOf(bytes);
  if (const Status checked = CheckJpeg(structure, bytes); !checked) return checked.error();
  DEEPSLAM_CHECK(structure.width % reduction == 0 && structure.height % reduction == 0,
                 "an image is reduced by a part of its size");
  return Decode<std::uint8_t>(bytes, structure, JCS_GRAYSCALE, reduction);
}

Result<std::string> EncodeJpeg(const ColourImage& image, int quality) {
  JpegWriter writer;
  if (!WritePixels(writer, image, quality))
    return Failed(fmt::format("cannot encode the image as JPEG ({})", writer.errors.fault.data()));
  return std::move(writer.destination.bytes);
}

}  // namespace deepslam::image_codec
