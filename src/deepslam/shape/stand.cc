#include "deepslam/shape/stand.h"

#include <algorithm>

namespace deepslam::shape {

void StandOnGround(int ground_k, int max_gap, VoxelGrid& grid) {
  const int bottom = std::clamp(ground_k, 0, kGridSize - 1);
  const int highest = std::min(kGridSize - 1, bottom + max_gap);
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      int lowest = bottom;
      while (lowest <= highest && !grid.At(i, j, lowest)) ++lowest;
      if (lowest > highest) continue;
      for (int k = bottom; k < lowest; ++k) grid.occupied[VoxelGrid::Index(i, j, k)] = 1;
    }
  }
}

}  // namespace deepslam::shape
