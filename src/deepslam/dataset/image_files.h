// Colour and depth images in files. Everything a file may do wrong comes back as an Error naming
// it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/raw_depth.h"

namespace deepslam::dataset {

using deepslam::RawDepthImage;  // of a depth image file: 16 bit, one channel

enum class ImageCodec { kPng, kJpeg, kOther };

// By the first bytes, whatever the name says.
[[nodiscard]] ImageCodec CodecOf(std::string_view bytes);

struct ImageSize {
  int width = 0;   // px
  int height = 0;  // px
};

// Size of a PNG or JPEG file by its header, without decoding it.
Result<ImageSize> ReadImageSize(const std::filesystem::path& file);

// Decodes a colour image of exactly width x height px. Grey, palette, 16-bit and alpha images are
// converted; rotation tags are ignored, since intrinsics belong to the stored pixels.
Result<ColourImage> ReadColourFile(const std::filesystem::path& file, int width, int height);
// The same of bytes in memory; `file` names them in messages.
Result<ColourImage> DecodeColour(std::string_view bytes,
                                 const std::filesystem::path& file,
                                 int width,
                                 int height);

// Intensity of such an image, averaged over blocks of factor x factor pixels. JPEG files are
// decoded without their colour and, by 2, 4 and 8, at that size: grey levels are whole there.
Result<IntensityImage> DecodeIntensity(
    std::string_view bytes, const std::filesystem::path& file, int width, int height, int factor);

// Depth that stands in a file as real numbers (OpenEXR, NumPy, TIFF) is held as whole ones of this
// many a metre: a third of a millimetre, up to 21.8 m.
inline constexpr double kRealDepthUnitsPerM = 3000;

// What a depth file is by its header: its size, and whether it holds real numbers.
struct DepthFileKind {
  int width = 0;   // px
  int height = 0;  // px
  bool real = false;
};
Result<DepthFileKind> ReadDepthKind(const std::filesystem::path& file);

// Decodes a depth image of exactly width x height px: one channel of 16 bits (PNG, PGM, TIFF, NPY),
// or real numbers (EXR, NPY, TIFF) times `raw_per_real`, rounded; those that are none, not above 0
// or too large become kNoDepth. `raw_per_real` 0: real numbers are refused, else whole ones are.
Result<RawDepthImage> ReadDepthFile(const std::filesystem::path& file,
                                    int width,
                                    int height,
                                    double raw_per_real = 0);

// Decodes an image of one channel of 8 bits (a confidence map).
Result<Image<std::uint8_t>> ReadGreyFile(const std::filesystem::path& file, int width, int height);

// As PNG or, by a name that ends so, as JPEG.
Status WriteColourFile(const std::filesystem::path& file,
                       const ColourImage& image,
                       int jpeg_quality = 95);
Status WriteDepthFile(const std::filesystem::path& file, const RawDepthImage& image);

}  // namespace deepslam::dataset
