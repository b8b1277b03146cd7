// Which space the frames of a capture looked through, in blocks of voxels.
//
// Block (i, j, k) reaches from 16 voxels times its index on, as the blocks of a fused surface do.
// Voxels of no block were never looked at.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace deepslam {

struct SpaceBlock {
  static constexpr int kSide = 16;  // voxels
  static constexpr std::size_t kVoxels = std::size_t{kSide} * kSide * kSide;

  Eigen::Vector3i index = Eigen::Vector3i::Zero();
  // Per voxel, z running fastest, counts of frames up to 255:
  std::array<std::uint8_t, kVoxels>
      passed{};                               // what was measured lies behind the voxel: it is free
  std::array<std::uint8_t, kVoxels> blind{};  // nothing was measured where the voxel lies: glass, a
                                              // mirror, the sky, or a surface seen too flat
};

class ObservedSpace {
 public:
  ObservedSpace() = default;
  // `voxel_m` > 0; blocks by ascending index (IsBefore), each once.
  ObservedSpace(double voxel_m, std::vector<SpaceBlock> blocks);

  // The order of blocks: by x, then y, then z.
  [[nodiscard]] static bool IsBefore(const Eigen::Vector3i& a, const Eigen::Vector3i& b);

  [[nodiscard]] double voxel_m() const { return voxel_m_; }
  [[nodiscard]] std::span<const SpaceBlock> blocks() const { return blocks_; }
  [[nodiscard]] bool empty() const { return blocks_.empty(); }
  // Counts of the voxel that holds the point; 0 where nothing was looked at.
  [[nodiscard]] int Passed(const Eigen::Vector3d& point) const;
  [[nodiscard]] int Blind(const Eigen::Vector3d& point) const;

 private:
  struct Place {
    const SpaceBlock* block = nullptr;
    std::size_t voxel = 0;
  };
  [[nodiscard]] Place PlaceOf(const Eigen::Vector3d& point) const;

  double voxel_m_ = 1;
  std::vector<SpaceBlock> blocks_;
};

}  // namespace deepslam
