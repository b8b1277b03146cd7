// A library model boiled down for fast fitting: its signed distance at half resolution and a sample
// of its surface.
#pragma once

#include <vector>

#include <Eigen/Core>

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
