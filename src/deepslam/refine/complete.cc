#include "deepslam/refine/complete.h"

#include <algorithm>
#include <cstddef>

#include "deepslam/core/check.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/stand.h"

namespace deepslam::refine {
namespace {

constexpr float kSure = 10;  // logit

VoxelGrid SurelySolid(std::span<const Evidence> evidence) {
  VoxelGrid grid;
  for (std::size_t n = 0; n < evidence.size(); ++n)
    grid.occupied[n] = evidence[n] == Evidence::kSolid ? 1 : 0;
  return grid;
}

}  // namespace

void AddMeasured(std::span<const Evidence> evidence,
                 int ground_k,
                 int max_gap,
                 std::vector<float>& logits) {
  DEEPSLAM_CHECK(evidence.size() == logits.size(), "evidence for each voxel");
  VoxelGrid measured = SurelySolid(evidence);
  shape::StandOnGround(ground_k, max_gap, measured);
  for (std::size_t n = 0; n < logits.size(); ++n) {
    if (measured.occupied[n] != 0) logits[n] = std::max(logits[n], kSure);
  }
}

}  // namespace deepslam::refine
