// The surface of a capture as elements, one per voxel: what things are put together from.
//
// All of it is in the level world of the surface (z up, ground at z = 0), metres.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace deepslam::instances {

// Points farther from the origin are none: the index of their voxel would not fit an int at any
// sensible size of voxels.
inline constexpr float kMaxCoordinateM = 1e5F;

using ElementPair = std::pair<int, int>;  // first below second

// One per voxel that holds vertices of the surface, in ascending order of the voxels' x, y, z.
class SurfaceElements {
 public:
  // The mean position and normal of the vertices in each voxel of side `voxel_m` > 0. Vertices that
  // are not finite, and voxels whose normals cancel out, give none.
  SurfaceElements(std::span<const Eigen::Vector3f> vertices,
                  std::span<const Eigen::Vector3f> normals,
                  double voxel_m);

  [[nodiscard]] double voxel_m() const { return voxel_m_; }
  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] const std::vector<Eigen::Vector3f>& points() const { return points_; }
  [[nodiscard]] const std::vector<Eigen::Vector3f>& normals() const { return normals_; }
  // Of each vertex that was given; -1: none.
  [[nodiscard]] const std::vector<int>& of_vertex() const { return of_vertex_; }

  // Pairs of elements nearer to each other than `reach_m` (at most two voxels), ascending.
  [[nodiscard]] std::vector<ElementPair> PairsWithin(double reach_m) const;

 private:
  using Voxel = Eigen::Vector3i;
  struct Hash {
    std::size_t operator()(const Voxel& voxel) const;
  };

  [[nodiscard]] Voxel VoxelOf(const Eigen::Vector3f& point) const;

  double voxel_m_;
  std::vector<Eigen::Vector3f> points_;
  std::vector<Eigen::Vector3f> normals_;
  std::vector<Voxel> voxels_;
  std::vector<int> of_vertex_;
  std::unordered_map<Voxel, int, Hash> element_at_;
};

}  // namespace deepslam::instances
