// Rectangles on the ground, turned about the vertical: outlines of upright boxes.
#pragma once

#include <Eigen/Core>

namespace deepslam {

struct LevelRectangle {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0;   // from the world's x axis to its own
  double length_m = 0;  // along its x axis; not negative
  double width_m = 0;   // along its y axis; not negative

  [[nodiscard]] double area_m2() const { return length_m * width_m; }
  [[nodiscard]] bool Contains(const Eigen::Vector2d& p) const;
};

// Area that both cover, m2.
[[nodiscard]] double SharedArea(const LevelRectangle& a, const LevelRectangle& b);

// The least rectangle along the axes of `a` that holds both.
[[nodiscard]] LevelRectangle HullAlong(const LevelRectangle& a, const LevelRectangle& b);

}  // namespace deepslam
