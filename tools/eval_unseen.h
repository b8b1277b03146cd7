// The true surface of a rendered capture's objects that none of its frames saw.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "eval_data.h"

namespace deepslam::tools {

// For each of truth.objects, in the true world; without what lies on the floor. InvalidInput where
// the capture has no instance masks, or a frame without true pose.
[[nodiscard]] Result<std::vector<std::vector<Eigen::Vector3d>>> UnseenPoints(const Truth& truth);

}  // namespace deepslam::tools
