// Colours over a plane, by cells. Where none was seen, what lies around goes over into each other,
// the smoother the farther away it is: pull-push interpolation (Gortler et al. 1996, The Lumigraph,
// 3.2.3).
#pragma once

#include <cstddef>

#include <Eigen/Geometry>

#include "deepslam/core/image.h"

namespace deepslam::mesh {

class ColourRaster {
 public:
  // Cells that cover the box, with their middles at whole steps; `step_m` wide, or wider where they
  // would be more than `max_cells`.
  ColourRaster(const Eigen::AlignedBox2d& box_m, double step_m, std::size_t max_cells);

  // Nothing outside the box.
  void Add(const Eigen::Vector2d& p_m, Rgb8 colour);
  [[nodiscard]] bool empty() const { return num_added_ == 0; }

  // The column and row of a point, of the nearest cell where it lies outside.
  [[nodiscard]] Eigen::Vector2i CellOf(const Eigen::Vector2d& p_m) const;
  // Of every cell: the mean of what was added there, or what the cells around say. Not of an empty
  // raster.
  [[nodiscard]] Image<Rgb8> Filled() const;

 private:
  // From the cell with the box's least corner; whole numbers.
  [[nodiscard]] Eigen::Vector2d Steps(const Eigen::Vector2d& p_m) const;

  Eigen::AlignedBox2d box_m_;
  double step_m_;
  Image<Eigen::Vector4d> sums_;  // red, green, blue, number of them
  std::size_t num_added_ = 0;
};

}  // namespace deepslam::mesh
