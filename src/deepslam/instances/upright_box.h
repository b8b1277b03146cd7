// The upright box of a set of points: the least rectangle on the ground that holds them, and the
// heights between which they lie.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/level_rectangle.h"

namespace deepslam::instances {

// World of the points: z up. The box's x axis is the world's turned by yaw_rad about z.
struct UprightBox {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0;   // [0, pi/2)
  double length_m = 0;  // along its x axis
  double width_m = 0;   // along its y axis
  double bottom_m = 0;
  double top_m = 0;

  [[nodiscard]] double long_side_m() const { return length_m > width_m ? length_m : width_m; }
  [[nodiscard]] double short_side_m() const { return length_m > width_m ? width_m : length_m; }
  [[nodiscard]] double height_m() const { return top_m - bottom_m; }
  // Along the longer side.
  [[nodiscard]] Eigen::Vector2d long_axis() const;
};

// The box seen from above, larger on all sides by a margin, or smaller where that is negative.
[[nodiscard]] LevelRectangle OutlineOf(const UprightBox& box, double margin_m = 0);

// Lowest and highest but for one in a hundred at either end. Of one value at least; reorders them.
[[nodiscard]] std::pair<double, double> ExtentOf(std::vector<double>& values);

// All sides leave out one point in a hundred at either end, so that single wrong points do not set
// them. All zero without points.
[[nodiscard]] UprightBox BoxOf(std::span<const Eigen::Vector3f> points);

}  // namespace deepslam::instances
