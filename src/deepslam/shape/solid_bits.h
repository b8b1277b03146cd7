// A voxel grid packed into bits: 32 KB, which rays that walk through it find in the nearest cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::shape {

class SolidBits {
 public:
  explicit SolidBits(const VoxelGrid& grid) : columns_(std::size_t{kGridSize} * kGridSize, 0) {
    static_assert(kGridSize == 64, "a column along k is one word");
    for (std::size_t n = 0; n < grid.occupied.size(); ++n)
      columns_[n / kGridSize] |= std::uint64_t{grid.occupied[n]} << n % kGridSize;
  }

  // Indices within the grid.
  [[nodiscard]] bool At(int i, int j, int k) const {
    const std::size_t column =
        static_cast<std::size_t>(i) * kGridSize + static_cast<std::size_t>(j);
    return (columns_[column] >> static_cast<unsigned>(k) & 1U) != 0;
  }

 private:
  std::vector<std::uint64_t> columns_;
};

}  // namespace deepslam::shape
