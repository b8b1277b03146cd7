// A library model boiled down for fast fitting: its signed distance at half resolution and a sample
// of its surface.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/point_columns.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/field_columns.h"

namespace deepslam::propose {

class CoarseShape {
 public:
  explicit CoarseShape(const VoxelGrid& grid);

  // Signed distances, object units, and their derivatives at the first `size` points of a batch,
  // all of them finite; not for an empty shape.
  void At(const VectorColumns& points_object,
          std::size_t size,
          shape::FieldSampleColumns& samples) const {
    shape::SampleField<kSize>(field_.data(), points_object, size, samples);
  }
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

}  // namespace deepslam::propose
