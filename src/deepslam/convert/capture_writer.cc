#include "deepslam/convert/capture_writer.h"

#include <algorithm>
#include <array>
#include <fstream>

#include <fmt/format.h>

#include "deepslam/image_codec/png.h"

namespace deepslam::convert {
namespace {

constexpr std::array<OutputFormat, 6> kOutputFormats = {{
    {.name = "tum",
     .remark = "camera and depth units lie in capture.yaml, for which the layout has no place",
     .create = CreateTum},
    {.name = "7scenes",
     .holds_unregistered = true,
     .holds_times = false,
     .colour_must_be_png = true,
     .fixed_units_per_m = 1000,
     .no_depth = kSaturatedDepth,
     .remark = "the cameras lie in capture.yaml, for which the layout has no place",
     .create = CreateSevenScenes},
    {.name = "scannet",
     .is_file = true,
     .holds_unregistered = true,
     .times_in_microseconds = true,
     .poses_in_floats = true,
     .remark = "version 4, depth as zlib streams, no motion measurements",
     .create = CreateScanNet},
    {.name = "open3d", .times_in_microseconds = true, .create = CreateOpen3d},
    {.name = "nerfstudio",
     .holds_times = false,
     .needs_poses = true,
     .fixed_units_per_m = 1000,
     .create = CreateNerfstudio},
    {.name = "colmap",
     .holds_times = false,
     .needs_poses = true,
     .holds_depth = false,
     .remark = "points3D.txt holds points out of the depth images, one in 3 cm, without tracks",
     .create = CreateColmap},
}};

}  // namespace

std::span<const OutputFormat> OutputFormats() { return kOutputFormats; }

const OutputFormat* FindOutputFormat(std::string_view name) {
  const auto found = std::find_if(kOutputFormats.begin(),
                                  kOutputFormats.end(),
                                  [&](const OutputFormat& format) { return format.name == name; });
  return found == kOutputFormats.end() ? nullptr : &*found;
}

Status WriteWhole(const std::filesystem::path& file, std::string_view bytes) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out)
    return Failed(fmt::format("{}: cannot be written; is the disk full or the folder read-only?",
                              file.string()));
  return Ok();
}

Status MakeFolder(const std::filesystem::path& folder) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) return Failed(fmt::format("{}: cannot be made ({})", folder.string(), code.message()));
  return Ok();
}

Result<std::string> ColourBytes(const dataset::StoredColour& colour) {
  if (colour.codec == dataset::ImageCodec::kOther) return image_codec::EncodePng(colour.pixels);
  return colour.bytes;
}

std::string_view ColourEnd(const dataset::StoredColour& colour) {
  return colour.codec == dataset::ImageCodec::kJpeg ? ".jpg" : ".png";
}

}  // namespace deepslam::convert
