#include "deepslam/refine/complete.h"

#include <algorithm>

#include "deepslam/core/check.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::refine {
namespace {

constexpr float kSure = 10;  // logit

}  // namespace

void AddMeasured(std::span<const Evidence> evidence,
                 int ground_k,
                 int max_gap,
                 std::vector<float>& logits) {
  DEEPSLAM_CHECK(evidence.size() == logits.size(), "evidence for each voxel");
  const int bottom = std::clamp(ground_k, 0, kGridSize - 1);
  const int highest = std::min(kGridSize - 1, bottom + max_gap);
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      int lowest = kGridSize;
      for (int k = kGridSize - 1; k >= 0; --k) {
        const std::size_t n = VoxelGrid::Index(i, j, k);
        if (evidence[n] != Evidence::kSolid) continue;
        logits[n] = std::max(logits[n], kSure);
        lowest = k;
      }
      if (lowest > highest) continue;
      for (int k = bottom; k < lowest; ++k) {
        float& logit = logits[VoxelGrid::Index(i, j, k)];
        logit = std::max(logit, kSure);
      }
    }
  }
}

}  // namespace deepslam::refine
