// The order in which a source of candidates offers them.
#pragma once

#include <algorithm>
#include <vector>

#include "deepslam/scene/shape_candidate.h"

namespace deepslam::propose {

// By proposal score; equal ones stay in the order in which they were found.
inline void BestFirst(std::vector<ShapeCandidate>& candidates) {
  std::stable_sort(
      candidates.begin(), candidates.end(), [](const ShapeCandidate& a, const ShapeCandidate& b) {
        return a.proposal_score > b.proposal_score;
      });
}

}  // namespace deepslam::propose
