// A capture with poses of a file instead of its own: those that tracking found, so that what is
// trained on elsewhere stands where the map does.
#pragma once

#include <filesystem>

#include "deepslam/core/result.h"
#include "deepslam/dataset/capture.h"

namespace deepslam::convert {

// `trajectory`: a list "time tx ty tz qx qy qz qw" (world from camera) at the times of the frames,
// or the folder of a run, of which the refined path is taken, else the tracked one. Frames without
// a line have no pose; none that has one is kInvalidInput.
[[nodiscard]] Status TakePosesOf(const std::filesystem::path& trajectory,
                                 dataset::Capture& capture);

}  // namespace deepslam::convert
