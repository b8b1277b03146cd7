// A truncated signed distance field in blocks of 16^3 voxels, opened where depth was measured.
//
// Block (i, j, k) reaches from 16 voxels times its index on; voxel centres lie half a voxel inside.
// The arithmetic is that of Open3D's ScalableTSDFVolume (Zhou and Koltun 2013), so that surfaces
// agree with it; a voxel takes 12 bytes instead of 48, and blocks are worked on side by side.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::fuse {

struct VoxelBlock {
  static constexpr int kSide = 16;  // voxels
  static constexpr std::size_t kVoxels = std::size_t{kSide} * kSide * kSide;
  static constexpr double kColourSteps = 256;  // of a grey value

  Eigen::Vector3i index;
  // Per voxel, z running fastest; colours channel by channel.
  std::array<float, kVoxels> distance{};        // share of the truncation, [-1, 1]
  std::array<std::uint16_t, kVoxels> weight{};  // how many images saw it; 0: nothing is known
  std::array<std::array<std::uint16_t, kVoxels>, 3> colour{};
};

class VoxelBlocks {
 public:
  VoxelBlocks(double voxel_m, double truncation_m);

  [[nodiscard]] double voxel_m() const { return voxel_m_; }
  [[nodiscard]] std::size_t size() const { return blocks_.size(); }
  // In the order in which they were opened.
  [[nodiscard]] const VoxelBlock& at(std::size_t number) const { return *blocks_[number]; }
  // Number of the block with this index; nothing where none is open.
  [[nodiscard]] std::optional<std::size_t> Find(const Eigen::Vector3i& index) const;

  // Opens the blocks that the truncation band of the depth image reaches and adds the image to
  // them. 0 is no depth; images of the camera's size. False, and nothing is changed, when there
  // would be more than `max_blocks`.
  //
  // `cosines` (incidence.h), where given: distances are those to the surface's plane, not along the
  // rays, and the voxel behind it is always known. Along a ray that grazes a surface the truncation
  // band is thinner than a voxel, and the surface would be lost.
  bool Integrate(const DepthImage& depth_m,
                 const ColourImage& colour,
                 const PinholeCamera& camera,
                 const Pose3& world_from_camera,
                 std::size_t max_blocks,
                 const Image<float>* cosines = nullptr);

 private:
  struct Hash {
    std::size_t operator()(const Eigen::Vector3i& index) const;
  };
  struct View;  // an image with what its camera makes of it

  [[nodiscard]] Eigen::Vector3i BlockOf(const Eigen::Vector3d& p_world) const;
  [[nodiscard]] std::vector<Eigen::Vector3i> Reached(const DepthImage& depth_m,
                                                     const PinholeCamera& camera,
                                                     const Pose3& world_from_camera) const;
  void Add(const View& view, VoxelBlock& block) const;

  double voxel_m_;
  double truncation_m_;
  std::vector<std::unique_ptr<VoxelBlock>> blocks_;
  std::unordered_map<Eigen::Vector3i, std::size_t, Hash> numbers_;
};

}  // namespace deepslam::fuse
