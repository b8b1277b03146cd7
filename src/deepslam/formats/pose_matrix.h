// Poses written as 4 x 4 matrices, row by row: 7-Scenes, Open3D, ScanNet.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "deepslam/geometry/pose.h"

namespace deepslam::formats {

// Nothing for what is not a pose: values that are not finite (ScanNet writes -inf, others nan, for
// lost frames), a zero matrix, no rotation (columns not of length 1 and square to each other within
// 1 %, a mirror), a position beyond 1000 km.
[[nodiscard]] std::optional<Pose3> PoseOfMatrix(std::span<const double, 16> row_major);

// Four lines of four numbers that read back to the same doubles.
[[nodiscard]] std::string FormatMatrix(const Pose3& b_from_a);

}  // namespace deepslam::formats
