// Whether two canonical models show the same product.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::library {

// A shape made ready to be compared with many others.
class ComparableShape {
 public:
  explicit ComparableShape(const VoxelGrid& grid);  // 1 MB beside the grid; `grid` must outlive it

  // After b is stretched to a's box, in any of the four quarter turns, their intersection over
  // union is above 0.9, or nearly all of each lies within a voxel of the other. Empty shapes are
  // like nothing.
  friend bool Alike(const ComparableShape& a, const ComparableShape& b);

 private:
  // Whether most of some of b's points, turned and stretched to a's box, lie on or beside a.
  static bool LiesNear(const ComparableShape& b, int quarter_turns, const ComparableShape& a);

  const VoxelGrid* grid_;
  Eigen::Vector3d extent_ = Eigen::Vector3d::Zero();  // of the occupied box, object units
  double fullness_ = 0;                               // occupied share of that box
  std::vector<float> squared_distance_;               // voxels, to the nearest occupied one
  Eigen::Array3d middle_ = Eigen::Array3d::Zero();    // of that box, voxels
  std::vector<Eigen::Array3d> some_;                  // occupied, in the box as in [-0.5, 0.5]^3
};

[[nodiscard]] bool Alike(const ComparableShape& a, const ComparableShape& b);

}  // namespace deepslam::library
