#include "deepslam/scene/voxel_grid.h"

namespace deepslam {

std::optional<VoxelBox> OccupiedBox(const VoxelGrid& grid) {
  VoxelBox box{Eigen::Array3i::Constant(kGridSize), Eigen::Array3i::Constant(-1)};
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        if (!grid.At(i, j, k)) continue;
        box.low = box.low.min(Eigen::Array3i(i, j, k));
        box.high = box.high.max(Eigen::Array3i(i, j, k));
      }
    }
  }
  if (box.high.x() < 0) return std::nullopt;
  return box;
}

}  // namespace deepslam
