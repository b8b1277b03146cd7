// ScanNet's .sens file: header, then frames one after another, then (version 4) motion
// measurements. All numbers little-endian; matrices row by row in 32-bit floats.
//
//   u32 version (3 or 4); u64 length, name of the sensor
//   f32[16] colour intrinsics, colour extrinsics, depth intrinsics, depth extrinsics
//   i32 colour codec, i32 depth codec; u32 colour width, height, depth width, height
//   f32 depth shift (raw value of one metre); u64 number of frames
//   per frame: f32[16] world from depth camera, u64 colour time, u64 depth time (microseconds),
//              u64 colour bytes, u64 depth bytes, colour, depth
//   version 4: u64 number of motion measurements, 128 bytes each
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/formats/sens_codecs.h"

namespace deepslam::formats {

struct SensHeader {
  std::uint32_t version = 4;
  std::string sensor_name;
  std::array<float, 16> colour_intrinsics{};
  std::array<float, 16> colour_extrinsics{};
  std::array<float, 16> depth_intrinsics{};
  std::array<float, 16> depth_extrinsics{};  // base frame from depth camera; usually colour's
  SensColourCodec colour_codec = SensColourCodec::kUnknown;
  SensDepthCodec depth_codec = SensDepthCodec::kUnknown;
  std::uint32_t colour_width = 0;
  std::uint32_t colour_height = 0;
  std::uint32_t depth_width = 0;
  std::uint32_t depth_height = 0;
  float depth_shift = 0;
  std::uint64_t num_frames = 0;
};

// Where a frame lies in the file.
struct SensFrame {
  std::array<float, 16> world_from_depth{};
  std::uint64_t colour_time_us = 0;
  std::uint64_t depth_time_us = 0;
  std::uint64_t colour_offset = 0;  // bytes from the beginning of the file
  std::uint64_t colour_bytes = 0;
  std::uint64_t depth_offset = 0;
  std::uint64_t depth_bytes = 0;
};

struct SensIndex {
  SensHeader header;
  std::vector<SensFrame> frames;  // those that lie in the file completely
  std::uint64_t num_motions = 0;  // version 4
};

// One pass over the file that reads no image. Every size and count is checked against the bytes
// that are there before memory is taken. A file that ends early gives the frames before its end;
// none of them is an error.
Result<SensIndex> ReadSensIndex(const std::filesystem::path& file);

// Bytes of a file; kInvalidInput when they are not there, kFailed when the machine does not give
// them.
Result<std::string> ReadRange(const std::filesystem::path& file,
                              std::uint64_t offset,
                              std::uint64_t num_bytes);

// What stands before the frames, and before a frame's images; with them a .sens file is written.
std::string EncodeSensHeader(const SensHeader& header);
std::string EncodeSensFrame(const SensFrame& frame);

// Where the number of frames stands in an encoded header, from its end.
inline constexpr std::size_t kSensNumFramesFromEnd = 8;

}  // namespace deepslam::formats
