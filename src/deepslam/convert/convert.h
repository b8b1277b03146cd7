// A capture of any layout written in another one, frame by frame. Images pass through as they are
// where the other layout can hold them; what it cannot hold is changed as little as possible and
// said.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "deepslam/convert/capture_writer.h"
#include "deepslam/core/result.h"
#include "deepslam/dataset/capture.h"

namespace deepslam::convert {

struct ConversionReport {
  std::string from;  // layouts
  std::string to;
  int num_frames = 0;   // written
  int num_skipped = 0;  // unreadable in the source
  int num_poses = 0;
  dataset::CaptureCameras cameras;  // of what was written
  std::vector<std::string> losses;  // what the result does not say any more, or not as exactly
  std::vector<std::string> notes;   // what was changed in form alone
};

// Called after each frame; false stops the conversion.
using ConversionProgress = std::function<bool(std::size_t done, std::size_t total)>;

// Writes `to` aside and renames it when it is whole; a failed or stopped conversion leaves nothing.
// Its report lies in it as conversion.json (beside it as NAME.conversion.json where the layout is
// one file). `depth_units_per_m` 0 keeps the source's units where the layout can hold them. Refuses
// (kInvalidConfig) a `to` that exists, an empty folder apart.
Result<ConversionReport> ConvertCapture(const dataset::Capture& capture,
                                        const std::filesystem::path& to,
                                        const OutputFormat& format,
                                        double depth_units_per_m,
                                        const ConversionProgress& progress);

// The report as JSON.
[[nodiscard]] std::string FormatReport(const ConversionReport& report);

}  // namespace deepslam::convert
