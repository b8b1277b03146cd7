// Degrees, as options and reports have them, and radians, as everything else has.
#pragma once

#include <numbers>

namespace deepslam {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;  // degrees times this are radians
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;  // radians times this are degrees

}  // namespace deepslam
