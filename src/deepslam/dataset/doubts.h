// What of a capture is hardly as it was meant: units, clocks and intrinsics of another image are
// wrong without being invalid, and give maps ten times too large, or none.
//
// Only what no room and no camera for rooms has is doubted. The capture is taken as it is.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"

namespace deepslam::dataset {

// Half of what a camera sees in a room, mostly 1 to 4 m, lies between these.
inline constexpr double kNearestMedianM = 0.5;  // of who films a table
inline constexpr double kFarthestMedianM = 6;   // of halls

// Principal point and angle of view.
[[nodiscard]] std::vector<std::string> CameraDoubts(const PinholeCamera& camera);

// The smaller unit that the times of a list seem to be in, taken for seconds; empty where they may
// well be seconds.
[[nodiscard]] std::string_view UnitOfTimes(std::span<const double> times_s);

// Times of the frames in their order, s.
[[nodiscard]] std::vector<std::string> TimeDoubts(std::span<const double> times_s);

// Pictures of some frames, none empty; nothing is recognised in those of one tone.
[[nodiscard]] std::vector<std::string> ColourDoubts(std::span<const IntensityImage> pictures);

// Depth of some frames, m, invalid 0.
[[nodiscard]] std::vector<std::string> DepthDoubts(std::span<const DepthImage> depths_m);

}  // namespace deepslam::dataset
