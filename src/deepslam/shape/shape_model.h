// A voxel model prepared for matching: surface points with outward normals and a signed distance
// field.
//
// Everything is in the object frame and in object units (scene/voxel_grid.h): z up, x front, cube
// [-0.5, 0.5]^3. The surface is the boundary between occupied and free voxels, half a voxel outside
// the centres of the surface voxels.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/geometry/point_columns.h"
#include "deepslam/geometry/trilinear.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/field_columns.h"

namespace deepslam::shape {

class ShapeModel {
 public:
  // Costs about 4 ms and 1.5 MB: make it once per model, not once per use.
  explicit ShapeModel(const VoxelGrid& grid);

  [[nodiscard]] const VoxelGrid& grid() const { return grid_; }
  // One point per surface voxel (occupied, a face neighbour free), on the surface: the voxel's
  // centre moved by half a voxel along its normal. Parts one voxel thin give one point per exposed
  // side instead. Ascending voxel index.
  [[nodiscard]] std::span<const Eigen::Vector3f> surface_points() const { return points_; }
  // Unit outward normals of the surface points.
  [[nodiscard]] std::span<const Eigen::Vector3f> surface_normals() const { return normals_; }
  // Signed distance to the surface, > 0 outside, < 0 inside; trilinear between voxel centres (exact
  // Euclidean there), also beyond the cube. A large positive constant for an empty model. With its
  // derivative: about unit length near the surface, zero for an empty model.
  struct Sample {
    float distance;
    Eigen::Vector3f gradient;
  };
  [[nodiscard]] Sample At(const Eigen::Vector3f& p_object) const {
    const bool is_inside = std::abs(p_object.x()) <= kInside && std::abs(p_object.y()) <= kInside &&
                           std::abs(p_object.z()) <= kInside;  // false for NaN
    return is_inside ? SampleInside(p_object) : BeyondCube(p_object);
  }
  [[nodiscard]] float Distance(const Eigen::Vector3f& p_object) const {
    return At(p_object).distance;
  }
  [[nodiscard]] Eigen::Vector3f Gradient(const Eigen::Vector3f& p_object) const {
    return At(p_object).gradient;
  }
  // The same for the first `size` points of a batch, all of them finite; not for an empty model.
  void At(const VectorColumns& points_object, std::size_t size, FieldSampleColumns& samples) const {
    SampleField<kGridSize>(field_.data(), points_object, size, samples);
  }
  // Signed distance at the centre of a voxel, object units.
  [[nodiscard]] float DistanceAt(int i, int j, int k) const {
    return field_[VoxelGrid::Index(i, j, k)];
  }

  // Box of the occupied voxels, object units; both zero for an empty model.
  [[nodiscard]] Eigen::Vector3f box_min() const { return box_min_; }
  [[nodiscard]] Eigen::Vector3f box_max() const { return box_max_; }
  [[nodiscard]] Eigen::Vector3f extent() const { return box_max_ - box_min_; }
  [[nodiscard]] Eigen::AlignedBox3f box() const { return {box_min_, box_max_}; }
  // Lowest z of the model: what stands on the ground.
  [[nodiscard]] float bottom() const { return box_min_.z(); }
  [[nodiscard]] bool empty() const { return points_.empty(); }

 private:
  // Centres of the outermost voxels.
  static constexpr auto kInside = static_cast<float>(0.5 - 0.5 * kVoxelSize);

  [[nodiscard]] Sample SampleInside(const Eigen::Vector3f& p_object) const {
    const Eigen::Array3f voxel = (p_object.array() + 0.5F) * static_cast<float>(kGridSize) - 0.5F;
    // Rounded down by the cast, as nothing inside is negative by more than rounding.
    const Eigen::Array3i base = voxel.cast<int>().max(0).min(kGridSize - 2);
    const Eigen::Array3f t = voxel - base.cast<float>();
    const TrilinearSample sample =
        SampleTrilinear(field_.data() + VoxelGrid::Index(base.x(), base.y(), base.z()),
                        std::size_t{kGridSize} * kGridSize,
                        kGridSize,
                        t);
    return {sample.value, sample.gradient * static_cast<float>(kGridSize)};
  }
  [[nodiscard]] Sample BeyondCube(const Eigen::Vector3f& p_object) const;

  VoxelGrid grid_;
  std::vector<float> field_;
  std::vector<Eigen::Vector3f> points_;
  std::vector<Eigen::Vector3f> normals_;
  Eigen::Vector3f box_min_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f box_max_ = Eigen::Vector3f::Zero();
};

// ShapeModel(grid).bottom(), for nothing else.
[[nodiscard]] float BottomOf(const VoxelGrid& grid);

}  // namespace deepslam::shape
