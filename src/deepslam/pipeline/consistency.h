// Whether the stages that lie in a workspace were made from one another.
#pragma once

#include <filesystem>

#include "deepslam/core/result.h"

namespace deepslam::pipeline {

// A run that stopped early (`--until`, a failure) leaves later stages of the run before it: a
// mixture that fits no capture. An InvalidInput error names the first stage whose input is no
// longer what it was made from, and the remedy; stages without a readable manifest are not checked.
// Options and program versions play no part.
[[nodiscard]] Status CheckConsistency(const std::filesystem::path& workspace);

}  // namespace deepslam::pipeline
