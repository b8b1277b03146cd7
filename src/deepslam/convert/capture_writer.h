// Captures written in the layouts of others, frame by frame: the other half of layout.h. Images
// come in the form in which the layout holds them; what has to be done to bring them there is
// convert.h.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/dataset/stored_frames.h"

namespace deepslam::convert {

struct WriteSettings {
  dataset::CaptureCameras cameras;  // of what is written
  bool has_times = true;            // false: times are made up
};

struct WriteFrame {
  std::int64_t number = 0;  // names the files; ascending, may have gaps
  double colour_time_s = 0;
  double depth_time_s = 0;
  std::optional<Pose3> world_from_colour;
  dataset::StoredColour colour;
  RawDepthImage depth;
};

class CaptureWriter {
 public:
  CaptureWriter() = default;
  virtual ~CaptureWriter() = default;
  CaptureWriter(const CaptureWriter&) = delete;
  CaptureWriter& operator=(const CaptureWriter&) = delete;

  [[nodiscard]] virtual Status Add(const WriteFrame& frame) = 0;
  // Lists, trajectory and calibration. Call once, at the end.
  [[nodiscard]] virtual Status Finish() = 0;
};

// What a layout can hold, and who writes it.
struct OutputFormat {
  std::string_view name;               // on the command line
  bool is_file = false;                // one file instead of a folder
  bool holds_unregistered = false;     // depth of another camera than colour's
  bool holds_times = true;             // else readers take 30 frames per second
  bool times_in_microseconds = false;  // whole ones only
  bool poses_in_floats = false;        // 32 bit
  bool colour_must_be_png = false;
  bool needs_poses = false;      // frames without one are left out
  bool holds_depth = true;       // as images
  double fixed_units_per_m = 0;  // 0: any
  std::uint16_t no_depth = kNoDepth;
  std::string_view remark = {};  // what a user of the result has to know; may be empty
  Result<std::unique_ptr<CaptureWriter>> (*create)(const std::filesystem::path& path,
                                                   const WriteSettings& settings);
};

[[nodiscard]] std::span<const OutputFormat> OutputFormats();
// Nothing for a name that is none.
[[nodiscard]] const OutputFormat* FindOutputFormat(std::string_view name);

// `path` is a folder that exists and is empty, or a file that does not exist.
Result<std::unique_ptr<CaptureWriter>> CreateTum(const std::filesystem::path& path,
                                                 const WriteSettings& settings);
Result<std::unique_ptr<CaptureWriter>> CreateSevenScenes(const std::filesystem::path& path,
                                                         const WriteSettings& settings);
Result<std::unique_ptr<CaptureWriter>> CreateOpen3d(const std::filesystem::path& path,
                                                    const WriteSettings& settings);
Result<std::unique_ptr<CaptureWriter>> CreateNerfstudio(const std::filesystem::path& path,
                                                        const WriteSettings& settings);
Result<std::unique_ptr<CaptureWriter>> CreateColmap(const std::filesystem::path& path,
                                                    const WriteSettings& settings);
Result<std::unique_ptr<CaptureWriter>> CreateScanNet(const std::filesystem::path& path,
                                                     const WriteSettings& settings);

// Shared by the writers. A file written in one go; kFailed when the disk does not take it.
[[nodiscard]] Status WriteWhole(const std::filesystem::path& file, std::string_view bytes);
[[nodiscard]] Status MakeFolder(const std::filesystem::path& folder);
// The bytes of an image file: those that are there, or the pixels as PNG.
[[nodiscard]] Result<std::string> ColourBytes(const dataset::StoredColour& colour);
// ".jpg" or ".png".
[[nodiscard]] std::string_view ColourEnd(const dataset::StoredColour& colour);

}  // namespace deepslam::convert
