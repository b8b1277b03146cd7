// Taking away what later stages no longer need, without forgetting that it was made.
#pragma once

#include <filesystem>
#include <string>

#include "deepslam/core/result.h"

namespace deepslam::pipeline {

// Removes the files of a finished stage but its manifest and timing, and leaves dropped.json beside
// them: the stage still counts as made, and is made again only when a stage that runs needs its
// files. A stage that never ran is left alone. The workspace must be held by the caller.
[[nodiscard]] Status DropOutputs(const std::filesystem::path& workspace, const std::string& stage);

// Whether DropOutputs was here.
[[nodiscard]] bool IsDropped(const std::filesystem::path& workspace, const std::string& stage);

}  // namespace deepslam::pipeline
