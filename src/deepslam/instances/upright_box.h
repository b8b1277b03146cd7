// The upright box of a set of points: the least rectangle on the ground that holds them, and the
// heights between which they lie.
#pragma once

#include <span>

#include <Eigen/Core>

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
};

// All sides leave out one point in a hundred at either end, so that single wrong points do not set
// them. All zero without points.
[[nodiscard]] UprightBox BoxOf(std::span<const Eigen::Vector3f> points);

}  // namespace deepslam::instances
