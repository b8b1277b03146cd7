// A capture.yaml for a folder of images beside which nothing tells of the camera.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/dataset/capture_settings.h"

namespace deepslam::layouts {

// Camera and depth's units as the images' sizes and values suggest them; what nobody has stated
// stands in `assumed`, so that every result is doubtful until somebody confirms it. kInvalidInput
// where the folder holds no colour and depth images in two folders.
[[nodiscard]] Result<dataset::CaptureSettings> SuggestSettings(const std::filesystem::path& folder);

// Writes them to FOLDER/capture.yaml, with words on what to correct. Refuses to write over a file.
[[nodiscard]] Status WriteSuggestedSettings(const std::filesystem::path& folder,
                                            const dataset::CaptureSettings& settings);

}  // namespace deepslam::layouts
