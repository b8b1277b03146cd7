// Sanity checks of a run: whether its map can be used as it is.
#pragma once

#include <span>
#include <string>

#include "deepslam/scene/measured_parts.h"
#include "deepslam/scene/optimized_map.h"
#include "deepslam/scene/run_verdict.h"

namespace deepslam::report {

// Bad: more than half of the frames lost, more than a fifth without a measured place relative to
// the rest, or no object. Doubtful: more than 5 % lost, any frames without a measured place, more
// than a quarter weakly constrained, a camera that jumps (path_jumps.h), few keyframes, no ground,
// a graph that did not converge, objects of little confidence, and whatever is doubted of the
// capture itself and of the detections given (`doubts`, sentences), which stands first. `joins`:
// what is known between keyframes, by tracking and by the loops.
[[nodiscard]] RunVerdict CheckRun(const OptimizedMap& map,
                                  std::span<const KeyframeJoin> joins,
                                  std::span<const std::string> doubts = {});

}  // namespace deepslam::report
