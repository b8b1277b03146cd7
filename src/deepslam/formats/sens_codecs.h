// How the images inside a ScanNet .sens file are packed. Everything here takes bytes of unknown
// origin: sizes are checked against what the bytes can hold before memory is taken.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/dataset/image_files.h"

namespace deepslam::formats {

enum class SensColourCodec : std::int32_t { kUnknown = -1, kRaw = 0, kPng = 1, kJpeg = 2 };
enum class SensDepthCodec : std::int32_t { kUnknown = -1, kRaw = 0, kZlib = 1, kOcci = 2 };

// Depth of one frame, width x height raw values, row by row. kRaw: 16 bit little-endian. kZlib: the
// same in a zlib stream. kOcci: Occipital's depth codec, whose values are the Structure Sensor's
// shifts; they become millimetres here (ShiftToMillimetres). Errors say what is wrong with the
// bytes; the caller names the file and frame.
Result<RawDepthImage> UnpackDepth(SensDepthCodec codec,
                                  std::string_view bytes,
                                  int width,
                                  int height);

// zlib stream of the raw values.
Result<std::string> PackDepthZlib(const RawDepthImage& depth);

// The Structure Sensor's shift as depth, mm, 0 = none. PrimeSense's relation with the pattern's
// reference plane at 90 mm of the pixel-size units, 7.5 cm baseline and 0.09 mm pixels comes to
// floor(300000 / (6809 / 6 - shift)); shifts 1 .. 1104 are depths 264 mm .. 9729 mm.
[[nodiscard]] std::uint16_t ShiftToMillimetres(int shift);

}  // namespace deepslam::formats
