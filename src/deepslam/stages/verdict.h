// Whether a run's map can be used as it is.
#pragma once

#include <string>
#include <vector>

#include "deepslam/artifact/map_json.h"
#include "deepslam/scene/optimized_map.h"

namespace deepslam::stages {

struct RunVerdict {
  artifact::Verdict verdict = artifact::Verdict::kGood;
  std::vector<std::string> reasons;
};

// Bad: more than half of the frames lost, or no object. Doubtful: more than 5 % lost, more than a
// quarter weakly constrained, no ground, a graph that did not converge, objects of little
// confidence.
[[nodiscard]] RunVerdict JudgeRun(const OptimizedMap& map);

}  // namespace deepslam::stages
