// capture.yaml: what the images alone do not say.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/geometry/camera.h"

namespace deepslam::dataset {

struct CaptureSettings {
  std::string format = "tum";
  PinholeCamera camera;          // of the colour images; depth is registered to them
  double depth_units_per_m = 0;  // value of one metre in the depth images
  std::vector<std::string> warnings;
};

// Reads the text of a capture.yaml; `file` names it in messages.
Result<CaptureSettings> ParseCaptureSettings(const std::string& text,
                                             const std::filesystem::path& file);

// Settings of a capture without capture.yaml, from the folder's name (TUM freiburg1, 2, 3); an
// error that shows how to write a capture.yaml when the name tells nothing.
Result<CaptureSettings> SettingsFromName(const std::filesystem::path& folder);

// The same settings as YAML text.
std::string FormatCaptureSettings(const CaptureSettings& settings);

// Refuses cameras no lens has: sizes outside 1 .. 16384 px, fields of view outside 1 .. 170
// degrees, a principal point outside the image. `file` names the source in messages.
Status CheckCamera(const PinholeCamera& camera, const std::filesystem::path& file);

}  // namespace deepslam::dataset
