// A library model boiled down for fast fitting: its signed distance at half resolution and a sample
// of its surface.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/geometry/trilinear.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::propose {

class CoarseShape {
 public:
  explicit CoarseShape(const VoxelGrid& grid);

  struct Sample {
    float distance;            // signed, object units
    Eigen::Vector3f gradient;  // about unit length
  };
  [[nodiscard]] Sample At(const Eigen::Vector3f& p_object) const;
  // Evenly drawn points of the surface, object units.
  [[nodiscard]] const std::vector<Eigen::Vector3f>& surface() const { return surface_; }
  // Centres of the outer solid cells of the half resolution, object units: what outlines are drawn
  // with.
  [[nodiscard]] const std::vector<Eigen::Vector3f>& solid() const { return solid_; }
  static constexpr int kSize = kGridSize / 2;           // cells along an axis
  static constexpr float kCellSide = 2.0F / kGridSize;  // object units
  [[nodiscard]] const Eigen::Vector3f& extent() const { return extent_; }
  [[nodiscard]] bool empty() const { return surface_.empty(); }

 private:
  std::vector<float> field_;
  std::vector<Eigen::Vector3f> surface_;
  std::vector<Eigen::Vector3f> solid_;
  Eigen::Vector3f extent_ = Eigen::Vector3f::Zero();
};

// Here, since it is asked millions of times an object.
inline CoarseShape::Sample CoarseShape::At(const Eigen::Vector3f& p_object) const {
  constexpr float kLimit = 0.5F - 0.5F / kSize;
  const Eigen::Vector3f inside = p_object.cwiseMax(-kLimit).cwiseMin(kLimit);
  // Rounded down by the cast, as nothing inside is negative by more than rounding.
  const Eigen::Array3f cell = (inside.array() + 0.5F) * kSize - 0.5F;
  const Eigen::Array3i base = cell.cast<int>().max(0).min(kSize - 2);
  const Eigen::Array3f t = cell - base.cast<float>();
  const std::size_t corner =
      (static_cast<std::size_t>(base.x()) * kSize + static_cast<std::size_t>(base.y())) * kSize +
      static_cast<std::size_t>(base.z());
  const TrilinearSample sample =
      SampleTrilinear(field_.data() + corner, std::size_t{kSize} * kSize, kSize, t);
  Eigen::Vector3f gradient = sample.gradient * kSize;
  float distance = sample.value;
  if (inside != p_object) {
    const Eigen::Vector3f nearest = inside - distance / std::max(gradient.norm(), 1e-6F) * gradient;
    gradient = (p_object - nearest).normalized();
    distance = (p_object - nearest).norm();
  }
  return {distance, gradient};
}

}  // namespace deepslam::propose
