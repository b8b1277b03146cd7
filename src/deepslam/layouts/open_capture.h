// Any known layout becomes a capture. Layouts: layout.h, docs/formats.md; capture.yaml, which may
// stand in any folder: dataset/capture_settings.h.
#pragma once

#include <filesystem>

#include "deepslam/core/result.h"
#include "deepslam/dataset/capture.h"

namespace deepslam::layouts {

// Opens a capture. Frames are read later, one at a time; here every file is read once for the hash,
// and a few frames are decoded so that a capture of which nothing can be used is refused now.
// Errors name file, line, field and remedy.
//
// Of more frames than capture.yaml's max_frames every n-th is taken, which a warning tells; or all.
enum class FramesTaken { kAtMostMaxFrames, kAll };
Result<dataset::Capture> OpenCapture(const std::filesystem::path& path,
                                     FramesTaken taken = FramesTaken::kAtMostMaxFrames);

}  // namespace deepslam::layouts
