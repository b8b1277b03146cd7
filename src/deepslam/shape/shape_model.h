// A voxel model prepared for matching: surface points with outward normals and a signed distance
// field.
//
// Everything is in the object frame and in object units (scene/voxel_grid.h): z up, x front, cube
// [-0.5, 0.5]^3. The surface is the boundary between occupied and free voxels, half a voxel outside
// the centres of the surface voxels.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/point_columns.h"
#include "deepslam/geometry/trilinear.h"
#include "deepslam/scene/voxel_grid.h"

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
  struct SampleColumns {
    PointColumn distance;
    VectorColumns gradient;
  };
  void At(const VectorColumns& points_object, std::size_t size, SampleColumns& samples) const;
  // Signed distance at the centre of a voxel, object units.
  [[nodiscard]] float DistanceAt(int i, int j, int k) const {
    return field_[VoxelGrid::Index(i, j, k)];
  }

  // Box of the occupied voxels, object units; both zero for an empty model.
  [[nodiscard]] Eigen::Vector3f box_min() const { return box_min_; }
  [[nodiscard]] Eigen::Vector3f box_max() const { return box_max_; }
  [[nodiscard]] Eigen::Vector3f extent() const { return box_max_ - box_min_; }
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

  struct SampleLane {
    float distance;
    Triple gradient;
  };
  // Of a point beyond the cube, from the sample at the point `inside` nearest to it: distance to
  // the surface point nearest to the cube's rim.
  static SampleLane Beyond(const Triple& inside, const SampleLane& sample, const Triple& p_object) {
    const float length = std::sqrt(Dot(sample.gradient, sample.gradient));
    const float per_length = sample.distance / (length > 1e-6F ? length : 1e-6F);
    const Triple away = p_object - (inside - per_length * sample.gradient);
    const float distance = std::sqrt(Dot(away, away));
    const float divisor = distance > 0 ? distance : 1.0F;
    return {distance, {away.x / divisor, away.y / divisor, away.z / divisor}};
  }
  static float Inside(float coordinate) {
    const float above = coordinate > -kInside ? coordinate : -kInside;
    return above < kInside ? above : kInside;
  }

  VoxelGrid grid_;
  std::vector<float> field_;
  std::vector<Eigen::Vector3f> points_;
  std::vector<Eigen::Vector3f> normals_;
  Eigen::Vector3f box_min_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f box_max_ = Eigen::Vector3f::Zero();
};

// Here, for its callers' loops, which are compiled for wide vectors.
inline void ShapeModel::At(const VectorColumns& points_object,
                           std::size_t size,
                           SampleColumns& samples) const {
  constexpr auto kGrid = static_cast<float>(kGridSize);
  constexpr std::size_t kRow = kGridSize, kLayer = kRow * kRow;
  VectorColumns inside, t;
  std::array<std::int32_t, kPointBatch> corner;
  std::array<PointColumn, 8> corners;
#pragma GCC ivdep
  for (std::size_t k = 0; k < size; ++k) {
    const float x = Inside(points_object.x[k]);
    const float y = Inside(points_object.y[k]);
    const float z = Inside(points_object.z[k]);
    inside.Set(k, x, y, z);
    // Rounded down by the cast, as nothing inside is negative by more than rounding.
    const float i = (x + 0.5F) * kGrid - 0.5F;
    const float j = (y + 0.5F) * kGrid - 0.5F;
    const float l = (z + 0.5F) * kGrid - 0.5F;
    const auto base = [](float voxel) {
      const auto truncated = static_cast<std::int32_t>(voxel);
      return truncated < kGridSize - 2 ? truncated : kGridSize - 2;
    };
    t.Set(k,
          i - static_cast<float>(base(i)),
          j - static_cast<float>(base(j)),
          l - static_cast<float>(base(l)));
    corner[k] = (base(i) * kGridSize + base(j)) * kGridSize + base(l);
  }
  for (std::size_t k = 0; k < size; ++k) {
    const float* const c = field_.data() + corner[k];
    corners[0][k] = c[0];
    corners[1][k] = c[1];
    corners[2][k] = c[kRow];
    corners[3][k] = c[kRow + 1];
    corners[4][k] = c[kLayer];
    corners[5][k] = c[kLayer + 1];
    corners[6][k] = c[kLayer + kRow];
    corners[7][k] = c[kLayer + kRow + 1];
  }
#pragma GCC ivdep
  for (std::size_t k = 0; k < size; ++k) {
    const TrilinearLane mixed = MixCorners({corners[0][k],
                                            corners[1][k],
                                            corners[2][k],
                                            corners[3][k],
                                            corners[4][k],
                                            corners[5][k],
                                            corners[6][k],
                                            corners[7][k]},
                                           t.x[k],
                                           t.y[k],
                                           t.z[k]);
    const SampleLane within = {mixed.value, kGrid * Triple{mixed.dx, mixed.dy, mixed.dz}};
    const Triple rim = TripleAt(inside, k);
    const Triple p = TripleAt(points_object, k);
    const SampleLane beyond = Beyond(rim, within, p);
    const bool is_inside = (rim.x == p.x) & (rim.y == p.y) & (rim.z == p.z);
    samples.distance[k] = is_inside ? within.distance : beyond.distance;
    samples.gradient.Set(k,
                         is_inside ? within.gradient.x : beyond.gradient.x,
                         is_inside ? within.gradient.y : beyond.gradient.y,
                         is_inside ? within.gradient.z : beyond.gradient.z);
  }
}

}  // namespace deepslam::shape
