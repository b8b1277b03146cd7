// The walls of a room in one frame, as lines on the ground: what stands against them is connected
// with them otherwise.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

namespace deepslam::detect {

// A measured point above the ground, the camera's foot at the origin.
struct UprightPoint {
  Eigen::Vector2d on_ground_m = Eigen::Vector2d::Zero();
  double height_m = 0;
  double depth_m = 0;        // along the camera's axis
  bool at_top_edge = false;  // of the image
};

struct Wall {
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  // unit, away from the camera
  double distance_m = 0;                              // from the camera's foot, > 0

  // Positive beyond the wall.
  [[nodiscard]] double Beyond(const Eigen::Vector2d& on_ground_m) const {
    return normal.dot(on_ground_m) - distance_m;
  }
};

// How far from its wall a measured point may lie, by the noise of structured light at its depth.
[[nodiscard]] double WallTolerance_m(double depth_m);

// Upright planes that are tall (or run out of the picture's top), long, and have next to nothing
// behind them; most area first. A wardrobe's front is none where the wall beside it shows. Areas
// are compared, so that points at any depth count alike.
[[nodiscard]] std::vector<Wall> FindWalls(std::span<const UprightPoint> points);

}  // namespace deepslam::detect
