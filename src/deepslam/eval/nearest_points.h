// Distances between point sets.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

namespace deepslam::eval {

// From each point of `from` to the nearest of `to`; infinite where `to` is empty.
[[nodiscard]] std::vector<double> NearestDistances(std::span<const Eigen::Vector3d> from,
                                                   std::span<const Eigen::Vector3d> to);

}  // namespace deepslam::eval
