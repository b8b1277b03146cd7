// Which side of an object its cameras saw.
#pragma once

#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace deepslam {

// How far an object (z up, x front) turns its back to cameras at these places of the same frame, in
// [0, 1]: 0 = all stand before it, 1 = all behind it; the mean of the horizontal angles' cosines.
// 0.5 without cameras.
[[nodiscard]] double BackShown(const Eigen::Quaterniond& world_from_object,
                               const Eigen::Vector3d& center_world,
                               std::span<const Eigen::Vector3d> cameras_world);

}  // namespace deepslam
