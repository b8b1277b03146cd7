#include "deepslam/dataset/image_files.h"

#include <cstring>
#include <fstream>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/scene/brightness.h"

namespace deepslam::dataset {
namespace {

// More than any compressed colour or depth image reaches; keeps a file of a few bytes from claiming
// memory for a picture of 16384 x 16384 px.
constexpr std::size_t kMaxPixelsPerByte = 1024;

// What the file's own structure says, found without decoding. Decoders fill the rest of a truncated
// JPEG with grey and allocate whatever size a header claims, so both are checked before.
struct ImageStructure {
  int width = 0;
  int height = 0;
  bool complete = false;
};

std::uint32_t BigEndian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  }
  return value;
}

std::optional<ImageStructure> PngStructure(std::string_view bytes) {
  constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
  if (!bytes.starts_with(kSignature)) return std::nullopt;
  ImageStructure structure;
  std::size_t at = kSignature.size();
  while (bytes.size() - at >= 12) {
    const std::size_t length = BigEndian(bytes, at, 4);
    const std::string_view type = bytes.substr(at + 4, 4);
    if (bytes.size() - at - 12 < length) break;
    if (type == "IHDR" && length >= 8 && structure.width == 0) {  // decoders take the first
      structure.width = static_cast<int>(BigEndian(bytes, at + 8, 4) & 0x7FFFFFFF);
      structure.height = static_cast<int>(BigEndian(bytes, at + 12, 4) & 0x7FFFFFFF);
    }
    if (type == "IEND") {
      structure.complete = true;
      break;
    }
    at += 12 + length;
  }
  return structure;
}

std::optional<ImageStructure> JpegStructure(std::string_view bytes) {
  if (!bytes.starts_with("\xFF\xD8\xFF")) return std::nullopt;
  ImageStructure structure;
  std::size_t at = 2;
  while (at + 4 <= bytes.size()) {
    if (bytes[at] != '\xFF') break;
    const auto marker = static_cast<unsigned char>(bytes[at + 1]);
    if (marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    const std::size_t length = BigEndian(bytes, at + 2, 2);
    const bool is_frame_header =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (is_frame_header && at + 9 <= bytes.size()) {
      structure.height = static_cast<int>(BigEndian(bytes, at + 5, 2));
      structure.width = static_cast<int>(BigEndian(bytes, at + 7, 2));
    }
    at += 2 + length;
    if (marker == 0xDA) {  // the coded pixels: only their end mark can stand there unescaped
      structure.complete =
          at < bytes.size() && bytes.find("\xFF\xD9", at) != std::string_view::npos;
      break;
    }
  }
  return structure;
}

Error FileError(const std::filesystem::path& file, std::string_view fault) {
  return InvalidInput(fmt::format("{}: {}", file.string(), fault));
}

Status CheckStructure(const std::filesystem::path& file,
                      std::string_view bytes,
                      int width,
                      int height) {
  std::optional<ImageStructure> structure = PngStructure(bytes);
  if (!structure) structure = JpegStructure(bytes);
  // Other decoders believe a header's size before the pixels are there.
  if (!structure)
    return FileError(file, "not a readable image (neither PNG nor JPEG): convert it to PNG");
  if (structure->width > 0 && (structure->width != width || structure->height != height)) {
    return FileError(file,
                     fmt::format("is {} x {} px, the camera {} x {}",
                                 structure->width,
                                 structure->height,
                                 width,
                                 height));
  }
  if (!structure->complete || structure->width < 1)
    return FileError(file, "image file ends too early (truncated or damaged)");
  if (static_cast<std::size_t>(width) * static_cast<std::size_t>(height) >
      kMaxPixelsPerByte * bytes.size()) {
    return FileError(
        file, fmt::format("has {} bytes, too few for {} x {} px", bytes.size(), width, height));
  }
  return Ok();
}

// `reduction`: by how much `flags` ask for a smaller image than the file holds.
Result<cv::Mat> Decode(std::string_view bytes,
                       const std::filesystem::path& file,
                       int flags,
                       int width,
                       int height,
                       int reduction = 1) {
  if (bytes.empty()) return FileError(file, "file is empty");
  const Status structure = CheckStructure(file, bytes, width, height);
  if (!structure) return structure.error();
  try {
    const cv::Mat raw(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    cv::Mat image = cv::imdecode(raw, flags);
    if (image.empty()) return FileError(file, "not a readable image");
    if (image.cols != width / reduction || image.rows != height / reduction) {
      return FileError(file,
                       fmt::format("is {} x {} px, the camera {} x {}",
                                   image.cols * reduction,
                                   image.rows * reduction,
                                   width,
                                   height));
    }
    return image;
  } catch (const cv::Exception& fault) {
    return FileError(file, fmt::format("not a readable image ({})", fault.err));
  }
}

Result<cv::Mat> DecodeFile(const std::filesystem::path& file, int flags, int width, int height) {
  const Result<std::string> bytes = ReadFileBytes(file);
  if (!bytes) return bytes.error();
  return Decode(*bytes, file, flags, width, height);
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

int GreyFlags(int reduction) {
  constexpr int kPlain = cv::IMREAD_IGNORE_ORIENTATION;
  if (reduction == 8) return cv::IMREAD_REDUCED_GRAYSCALE_8 | kPlain;
  if (reduction == 4) return cv::IMREAD_REDUCED_GRAYSCALE_4 | kPlain;
  if (reduction == 2) return cv::IMREAD_REDUCED_GRAYSCALE_2 | kPlain;
  return cv::IMREAD_GRAYSCALE | kPlain;
}

cv::Mat ToBgr(const ColourImage& image) {
  cv::Mat bgr(image.height(), image.width(), CV_8UC3);
  for (int v = 0; v < image.height(); ++v) {
    unsigned char* out = bgr.ptr<unsigned char>(v);
    const Rgb8* rgb = image.row(v);
    for (int u = 0; u < image.width(); ++u, out += 3) {
      out[0] = rgb[u].b;
      out[1] = rgb[u].g;
      out[2] = rgb[u].r;
    }
  }
  return bgr;
}

cv::Mat ToMat(const RawDepthImage& image) {
  cv::Mat raw(image.height(), image.width(), CV_16UC1);
  for (int v = 0; v < image.height(); ++v) {
    std::memcpy(
        raw.ptr(v), image.row(v), static_cast<std::size_t>(image.width()) * sizeof(std::uint16_t));
  }
  return raw;
}

Result<std::string> Encode(const cv::Mat& image) {
  try {
    std::vector<unsigned char> bytes;
    if (!cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 3}))
      return Failed("cannot encode the image");
    return std::string(bytes.begin(), bytes.end());
  } catch (const cv::Exception& fault) {
    return Failed(fmt::format("cannot encode the image ({})", fault.err));
  }
}

Status Write(const std::filesystem::path& file,
             const cv::Mat& image,
             const std::vector<int>& parameters) {
  try {
    std::vector<unsigned char> bytes;
    if (!cv::imencode(file.extension().string(), image, bytes, parameters)) {
      return Failed(fmt::format("{}: cannot encode the image", file.string()));
    }
    std::ofstream out(file, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out)
      return Failed(fmt::format("{}: cannot be written; is the disk full or the folder read-only?",
                                file.string()));
    return Ok();
  } catch (const cv::Exception& fault) {
    return Failed(fmt::format("{}: cannot encode the image ({})", file.string(), fault.err));
  }
}

}  // namespace

ImageCodec CodecOf(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG")) return ImageCodec::kPng;
  if (bytes.starts_with("\xFF\xD8\xFF")) return ImageCodec::kJpeg;
  return ImageCodec::kOther;
}

Result<ImageSize> ReadImageSize(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFileBytes(file);
  if (!bytes) return bytes.error();
  std::optional<ImageStructure> structure = PngStructure(*bytes);
  if (!structure) structure = JpegStructure(*bytes);
  if (!structure) return FileError(file, "is neither a PNG nor a JPEG image");
  if (structure->width < 1 || structure->height < 1)
    return FileError(file, "image file ends too early (truncated or damaged)");
  return ImageSize{structure->width, structure->height};
}

Result<ColourImage> DecodeColour(std::string_view bytes,
                                 const std::filesystem::path& file,
                                 int width,
                                 int height) {
  const Result<cv::Mat> decoded =
      Decode(bytes,
             file,
             cv::IMREAD_COLOR | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION,
             width,
             height);
  if (!decoded) return decoded.error();
  if (decoded->type() != CV_8UC3)
    return FileError(file, "has 16 bits per channel, a colour image 8: is it a depth image?");
  ColourImage image(width, height);
  for (int v = 0; v < height; ++v) {
    const unsigned char* bgr = decoded->ptr<unsigned char>(v);
    Rgb8* rgb = image.row(v);
    for (int u = 0; u < width; ++u, bgr += 3) rgb[u] = {bgr[2], bgr[1], bgr[0]};
  }
  return image;
}

Result<BrightnessImage> DecodeBrightness(
    std::string_view bytes, const std::filesystem::path& file, int width, int height, int factor) {
  if (CodecOf(bytes) != ImageCodec::kJpeg) {
    const Result<ColourImage> colour = DecodeColour(bytes, file, width, height);
    if (!colour) return colour.error();
    return BrightnessOf(*colour, factor);
  }
  const int reduction = JpegReduction(width, height, factor);
  const Result<cv::Mat> grey = Decode(bytes, file, GreyFlags(reduction), width, height, reduction);
  if (!grey) return grey.error();
  BrightnessImage brightness(grey->cols, grey->rows);
  for (int v = 0; v < grey->rows; ++v)
    std::copy_n(grey->ptr<unsigned char>(v), grey->cols, brightness.row(v));
  if (reduction == factor) return brightness;
  return ReducedBrightness(brightness, factor / reduction);
}

Result<ColourImage> ReadColourFile(const std::filesystem::path& file, int width, int height) {
  const Result<std::string> bytes = ReadFileBytes(file);
  if (!bytes) return bytes.error();
  return DecodeColour(*bytes, file, width, height);
}

Result<RawDepthImage> ReadDepthFile(const std::filesystem::path& file, int width, int height) {
  const Result<cv::Mat> decoded = DecodeFile(file, cv::IMREAD_UNCHANGED, width, height);
  if (!decoded) return decoded.error();
  if (decoded->type() != CV_16UC1) {
    return FileError(file,
                     fmt::format("depth must have one channel of 16 bits, this has {} of {} bits",
                                 decoded->channels(),
                                 8 * decoded->elemSize1()));
  }
  RawDepthImage image(width, height);
  for (int v = 0; v < height; ++v) {
    std::memcpy(
        image.row(v), decoded->ptr(v), static_cast<std::size_t>(width) * sizeof(std::uint16_t));
  }
  return image;
}

Result<Image<std::uint8_t>> ReadGreyFile(const std::filesystem::path& file, int width, int height) {
  const Result<cv::Mat> decoded = DecodeFile(file, cv::IMREAD_UNCHANGED, width, height);
  if (!decoded) return decoded.error();
  if (decoded->type() != CV_8UC1) {
    return FileError(file,
                     fmt::format("must have one channel of 8 bits, this has {} of {} bits",
                                 decoded->channels(),
                                 8 * decoded->elemSize1()));
  }
  Image<std::uint8_t> image(width, height);
  for (int v = 0; v < height; ++v)
    std::memcpy(image.row(v), decoded->ptr(v), static_cast<std::size_t>(width));
  return image;
}

Result<std::string> EncodePng(const ColourImage& image) { return Encode(ToBgr(image)); }
Result<std::string> EncodePng(const RawDepthImage& image) { return Encode(ToMat(image)); }

Status WriteColourFile(const std::filesystem::path& file,
                       const ColourImage& image,
                       int jpeg_quality) {
  return Write(file, ToBgr(image), {cv::IMWRITE_JPEG_QUALITY, jpeg_quality});
}

Status WriteDepthFile(const std::filesystem::path& file, const RawDepthImage& image) {
  return Write(file, ToMat(image), {cv::IMWRITE_PNG_COMPRESSION, 3});
}

}  // namespace deepslam::dataset
