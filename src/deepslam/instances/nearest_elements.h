// Which element of a surface a point lies on, by one look-up: for all pixels of all frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "deepslam/instances/surface_elements.h"

namespace deepslam::instances {

// Cells half as wide as the elements' voxels, in blocks where there is surface. 2 KB per block of
// eight cells to a side. World and units of the elements.
class NearestElements {
 public:
  explicit NearestElements(const SurfaceElements& elements);

  // Look-ups in turn of points near each other: the block of the last one is tried first.
  class Cursor {
   public:
    explicit Cursor(const NearestElements& nearest) : nearest_(nearest) {}
    // The element nearest to the middle of the point's cell, no farther from it than a voxel and a
    // half; -1: none.
    [[nodiscard]] int At(const Eigen::Vector3f& point);

   private:
    const NearestElements& nearest_;
    Eigen::Vector3i block_ = Eigen::Vector3i::Constant(kNoBlock);
    const std::int32_t* cells_ = nullptr;
  };

 private:
  static constexpr int kBlockBits = 3;  // cells of a block along an axis, as a power of two
  static constexpr int kBlockSide = 1 << kBlockBits;  // cells
  // No block of cells has such an index.
  static constexpr int kNoBlock = 1 << 30;
  struct Hash {
    std::size_t operator()(const Eigen::Vector3i& block) const;
  };

  void Offer(int element, const SurfaceElements& elements);
  [[nodiscard]] std::size_t FirstCellOf(const Eigen::Vector3i& block);

  float cell_m_;
  std::unordered_map<Eigen::Vector3i, std::size_t, Hash> first_cell_of_;
  std::vector<std::int32_t> element_of_cell_;  // -1: none
};

}  // namespace deepslam::instances
