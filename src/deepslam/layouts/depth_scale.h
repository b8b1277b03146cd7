// The raw depth of one metre as JSON files beside images state it, under the names that recorders
// and scripts give it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"

namespace deepslam::layouts {

// "depth_scale", "depthScale", "depth_factor", "depth_units", ... at the top of the file or in
// objects in it. Less than 0.1 is what one unit of depth has in metres (RealSense's 0.001): its
// reciprocal is taken, with a warning. Nothing where none stands there
// or it is no JSON; kInvalidInput that names
// the field where it is no number in 1 .. 1000000, or where two differ.
[[nodiscard]] Result<std::optional<double>> FindDepthScale(std::string_view json,
                                                           const std::filesystem::path& file,
                                                           std::vector<std::string>& warnings);

}  // namespace deepslam::layouts
