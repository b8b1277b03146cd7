// Where to cut a body so that both halves are nearer to convex.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/convex/polygon_soup.h"

namespace deepslam::convex {

// Planes across the axes, the diagonals between two of them and the principal axes of `centres`:
// along each the place that leaves the smallest sum of volumes of the two boxes with the halves'
// second moments, which stand in for hulls and which sums of moments give at every place. The
// `max_cuts` best, best first; none where no plane has cells on both sides.
[[nodiscard]] std::vector<CutPlane> BestCuts(std::span<const Eigen::Vector3f> centres,
                                             float cell_m,
                                             std::size_t max_cuts);

}  // namespace deepslam::convex
