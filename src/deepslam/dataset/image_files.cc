#include "deepslam/dataset/image_files.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <variant>

#include <fmt/format.h>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/frames/intensity.h"
#include "deepslam/image_codec/decode.h"
#include "deepslam/image_codec/depth_image.h"
#include "deepslam/image_codec/jpeg.h"
#include "deepslam/image_codec/png.h"
#include "deepslam/image_codec/structure.h"

namespace deepslam::dataset {
namespace {

namespace codec = image_codec;

Error ImageError(const std::filesystem::path& file, std::string_view fault) {
  return InvalidInput(fmt::format("{}: {}", file.string(), fault));
}

bool IsPngOrJpeg(const codec::ImageStructure& structure) {
  return structure.format == codec::ImageFormat::kPng ||
         structure.format == codec::ImageFormat::kJpeg;
}

// Of a whole image of the camera's size.
Result<codec::ImageStructure> CheckedStructure(const std::filesystem::path& file,
                                               std::string_view bytes,
                                               int width,
                                               int height) {
  if (bytes.empty()) return ImageError(file, "file is empty");
  const codec::ImageStructure structure = codec::StructureOf(bytes);
  if (!IsPngOrJpeg(structure))
    return ImageError(file, "not a readable image (neither PNG nor JPEG): convert it to PNG");
  if (structure.width > 0 && (structure.width != width || structure.height != height)) {
    return ImageError(
        file,
        fmt::format(
            "is {} x {} px, the camera {} x {}", structure.width, structure.height, width, height));
  }
  if (const Status checked = codec::CheckStructure(structure, bytes); !checked)
    return ImageError(file, checked.error().message);
  return structure;
}

template <typename T>
Result<T> Named(const std::filesystem::path& file, Result<T> decoded) {
  if (decoded) return decoded;
  return ImageError(file, fmt::format("not a readable image ({})", decoded.error().message));
}

// The most that JPEG's own blocks of 8 x 8 pixels let a file be reduced by in decoding, of
// `factor`.
int JpegReduction(int width, int height, int factor) {
  for (const int reduction : {8, 4, 2}) {
    if (factor % reduction == 0 && width % reduction == 0 && height % reduction == 0)
      return reduction;
  }
  return 1;
}

std::string Extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return extension;
}

Result<std::string> EncodeFor(const std::filesystem::path& file,
                              const ColourImage& image,
                              int jpeg_quality) {
  const std::string extension = Extension(file);
  if (extension == ".png") return codec::EncodePng(image);
  if (extension == ".jpg" || extension == ".jpeg") return codec::EncodeJpeg(image, jpeg_quality);
  return InvalidInput(
      fmt::format("images are written as .png, .jpg or .jpeg, not as '{}'", extension));
}

Status Write(const std::filesystem::path& file, const Result<std::string>& bytes) {
  if (!bytes) return Error{bytes.error().code, file.string() + ": " + bytes.error().message};
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out.write(bytes->data(), static_cast<std::streamsize>(bytes->size()));
  out.close();
  if (out) return Ok();
  return Failed(fmt::format("{}: cannot be written; is the disk full or the folder read-only?",
                            file.string()));
}

// Where the camera has depth of another size something has to say what lies between the two.
constexpr std::string_view kDepthCameraRemedy =
    "; where depth has a camera of its own, state 'depth_camera' and 'colour_from_depth' in "
    "capture.yaml, or register depth to colour first (k4a_transformation, rs-align)";

RawDepthImage Rounded(const Image<float>& real, double raw_per_real) {
  RawDepthImage raw(real.width(), real.height());
  std::transform(real.begin(), real.end(), raw.begin(), [&](float value) {
    const double scaled = static_cast<double>(value) * raw_per_real;
    return scaled >= 0.5 && scaled < kSaturatedDepth - 0.5
               ? static_cast<std::uint16_t>(std::lround(scaled))
               : kNoDepth;
  });
  return raw;
}

Result<codec::DepthStructure> DepthStructureOf(const std::filesystem::path& file,
                                               std::string_view bytes) {
  if (bytes.empty()) return ImageError(file, "file is empty");
  if (codec::FormatOf(bytes) == codec::ImageFormat::kJpeg) {
    return ImageError(file,
                     "depth must have one channel of 16 bits, this is a JPEG image, which has 8; "
                     "store depth as 16-bit PNG");
  }
  Result<codec::DepthStructure> structure = codec::DepthStructureOf(bytes);
  if (!structure) return ImageError(file, structure.error().message);
  return structure;
}

}  // namespace

ImageCodec CodecOf(std::string_view bytes) {
  switch (codec::FormatOf(bytes)) {
    case codec::ImageFormat::kPng:
      return ImageCodec::kPng;
    case codec::ImageFormat::kJpeg:
      return ImageCodec::kJpeg;
    default:
      return ImageCodec::kOther;
  }
}

Result<ImageSize> ReadImageSize(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFileBytes(file);
  if (!bytes) return bytes.error();
  const codec::ImageStructure structure = codec::StructureOf(*bytes);
  if (!IsPngOrJpeg(structure)) return ImageError(file, "is neither a PNG nor a JPEG image");
  if (structure.width < 1 || structure.height < 1)
    return ImageError(file, "image file ends too early (truncated or damaged)");
  return ImageSize{structure.width, structure.height};
}

Result<ColourImage> DecodeColour(std::string_view bytes,
                                 const std::filesystem::path& file,
                                 int width,
                                 int height) {
  const Result<codec::ImageStructure> structure = CheckedStructure(file, bytes, width, height);
  if (!structure) return structure.error();
  if (structure->bits != 8)
    return ImageError(file, "has 16 bits per channel, a colour image 8: is it a depth image?");
  return Named(file, codec::DecodeColour(bytes));
}

Result<IntensityImage> DecodeIntensity(
    std::string_view bytes, const std::filesystem::path& file, int width, int height, int factor) {
  const Result<codec::ImageStructure> structure = CheckedStructure(file, bytes, width, height);
  if (!structure) return structure.error();
  if (structure->format != codec::ImageFormat::kJpeg || structure->channels == 4) {
    const Result<ColourImage> colour = DecodeColour(bytes, file, width, height);
    if (!colour) return colour.error();
    return IntensityOf(*colour, factor);
  }
  const int reduction = JpegReduction(width, height, factor);
  const Result<Image<std::uint8_t>> grey = Named(file, codec::DecodeJpegGrey(bytes, reduction));
  if (!grey) return grey.error();
  IntensityImage intensity(grey->width(), grey->height());
  std::copy(grey->begin(), grey->end(), intensity.begin());
  if (reduction == factor) return intensity;
  return ReducedIntensity(intensity, factor / reduction);
}

Result<ColourImage> ReadColourFile(const std::filesystem::path& file, int width, int height) {
  const Result<std::string> bytes = ReadFileBytes(file);
  if (!bytes) return bytes.error();
  return DecodeColour(*bytes, file, width, height);
}

Result<DepthFileKind> ReadDepthKind(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFileBytes(file);
  if (!bytes) return bytes.error();
  const Result<codec::DepthStructure> structure = DepthStructureOf(file, *bytes);
  if (!structure) return structure.error();
  return DepthFileKind{structure->width, structure->height, structure->real};
}

Result<RawDepthImage> ReadDepthFile(const std::filesystem::path& file,
                                    int width,
                                    int height,
                                    double raw_per_real) {
  const Result<std::string> bytes = ReadFileBytes(file);
  if (!bytes) return bytes.error();
  const Result<codec::DepthStructure> structure = DepthStructureOf(file, *bytes);
  if (!structure) return structure.error();
  if (structure->width != width || structure->height != height) {
    return ImageError(file,
                     fmt::format("is {} x {} px, the camera {} x {}{}",
                                 structure->width,
                                 structure->height,
                                 width,
                                 height,
                                 kDepthCameraRemedy));
  }
  if (structure->real != (raw_per_real > 0)) {
    return ImageError(file,
                     fmt::format("holds depth as {} numbers, the capture's first image as {} ones",
                                 structure->real ? "real" : "whole",
                                 structure->real ? "whole" : "real"));
  }
  Result<codec::DepthPixels> pixels = codec::DecodeDepth(*bytes);
  if (!pixels)
    return ImageError(file, fmt::format("not a readable image ({})", pixels.error().message));
  if (auto* const whole = std::get_if<RawDepthImage>(&*pixels)) return std::move(*whole);
  return Rounded(std::get<Image<float>>(*pixels), raw_per_real);
}

Result<Image<std::uint8_t>> ReadGreyFile(const std::filesystem::path& file, int width, int height) {
  const Result<std::string> bytes = ReadFileBytes(file);
  if (!bytes) return bytes.error();
  const Result<codec::ImageStructure> structure = CheckedStructure(file, *bytes, width, height);
  if (!structure) return structure.error();
  if (structure->channels != 1 || structure->bits != 8) {
    return ImageError(file,
                     fmt::format("must have one channel of 8 bits, this has {} of {} bits",
                                 structure->channels,
                                 structure->bits));
  }
  const bool is_jpeg = structure->format == codec::ImageFormat::kJpeg;
  return Named(file, is_jpeg ? codec::DecodeJpegGrey(*bytes) : codec::DecodePngGrey(*bytes));
}

Status WriteColourFile(const std::filesystem::path& file,
                       const ColourImage& image,
                       int jpeg_quality) {
  return Write(file, EncodeFor(file, image, jpeg_quality));
}

Status WriteDepthFile(const std::filesystem::path& file, const RawDepthImage& image) {
  return Write(file, codec::EncodePng(image));
}

}  // namespace deepslam::dataset
