#include "deepslam/shape/small_components.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace deepslam::shape {
namespace {

// Takes the part of voxel `first` out of `left`.
std::vector<std::size_t> TakePart(std::size_t first, int reach, std::vector<std::uint8_t>& left) {
  std::vector<std::size_t> part = {first};
  left[first] = 0;
  for (std::size_t n = 0; n < part.size(); ++n) {
    const int at = static_cast<int>(part[n]);
    const int i = at / (kGridSize * kGridSize);
    const int j = at / kGridSize % kGridSize;
    const int k = at % kGridSize;
    for (int a = std::max(0, i - reach); a <= std::min(kGridSize - 1, i + reach); ++a) {
      for (int b = std::max(0, j - reach); b <= std::min(kGridSize - 1, j + reach); ++b) {
        for (int c = std::max(0, k - reach); c <= std::min(kGridSize - 1, k + reach); ++c) {
          const std::size_t next = VoxelGrid::Index(a, b, c);
          if (left[next] == 0) continue;
          left[next] = 0;
          part.push_back(next);
        }
      }
    }
  }
  return part;
}

}  // namespace

std::vector<std::vector<std::size_t>> PartsOf(const VoxelGrid& grid, int reach) {
  std::vector<std::vector<std::size_t>> parts;
  std::vector<std::uint8_t> left = grid.occupied;
  for (std::size_t first = 0; first < left.size(); ++first) {
    if (left[first] != 0) parts.push_back(TakePart(first, reach, left));
  }
  return parts;
}

VoxelGrid WithoutSmallComponents(const VoxelGrid& grid, int reach, double min_share) {
  const auto total = std::count(grid.occupied.begin(), grid.occupied.end(), std::uint8_t{1});
  const double fewest = min_share * static_cast<double>(total);
  VoxelGrid kept;
  for (const std::vector<std::size_t>& part : PartsOf(grid, reach)) {
    if (static_cast<double>(part.size()) < fewest) continue;
    for (const std::size_t n : part) kept.occupied[n] = 1;
  }
  return kept;
}

}  // namespace deepslam::shape
