// A box of samples, for measures that other programs define on grids of any size.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::eval {

// Sample (i, j, k) lies at the point (i, j, k); k runs fastest.
struct Volume {
  std::array<int, 3> size = {0, 0, 0};
  std::vector<float> values;

  Volume() = default;
  explicit Volume(std::array<int, 3> shape)
      : size(shape),
        values(static_cast<std::size_t>(shape[0]) * static_cast<std::size_t>(shape[1]) *
               static_cast<std::size_t>(shape[2])) {}
  explicit Volume(const VoxelGrid& grid)
      : size({kGridSize, kGridSize, kGridSize}),
        values(grid.occupied.begin(), grid.occupied.end()) {}

  [[nodiscard]] std::size_t Index(int i, int j, int k) const {
    return (static_cast<std::size_t>(i) * static_cast<std::size_t>(size[1]) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size[2]) +
           static_cast<std::size_t>(k);
  }
  float& operator()(int i, int j, int k) { return values[Index(i, j, k)]; }
  float operator()(int i, int j, int k) const { return values[Index(i, j, k)]; }
};

}  // namespace deepslam::eval
