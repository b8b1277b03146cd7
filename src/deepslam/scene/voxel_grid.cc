#include "deepslam/scene/voxel_grid.h"

#include <cstdint>
#include <cstring>

namespace deepslam {

std::optional<VoxelBox> OccupiedBox(const VoxelGrid& grid) {
  VoxelBox box{Eigen::Array3i::Constant(kGridSize), Eigen::Array3i::Constant(-1)};
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      const std::uint8_t* const column = grid.occupied.data() + VoxelGrid::Index(i, j, 0);
      const void* const lowest = std::memchr(column, 1, kGridSize);
      if (lowest == nullptr) continue;
      int highest = kGridSize - 1;
      while (column[highest] == 0) --highest;
      const auto k = static_cast<int>(static_cast<const std::uint8_t*>(lowest) - column);
      box.low = box.low.min(Eigen::Array3i(i, j, k));
      box.high = box.high.max(Eigen::Array3i(i, j, highest));
    }
  }
  if (box.high.x() < 0) return std::nullopt;
  return box;
}

}  // namespace deepslam
