// Convex outlines on the ground.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace deepslam::segment {

// Points in two coordinates, one array for each.
struct PlanarPoints {
  std::vector<double> x_m;
  std::vector<double> y_m;
};

// Convex, counter-clockwise; fewer than three points when all lie on a line.
[[nodiscard]] std::vector<Eigen::Vector2d> ConvexHull(const PlanarPoints& points);

// Twice the area of a counter-clockwise polygon.
[[nodiscard]] double DoubleArea(std::span<const Eigen::Vector2d> hull);

// Tells points that lie no farther than a margin outside each edge of a convex polygon.
class WithinHull {
 public:
  WithinHull(std::span<const Eigen::Vector2d> hull, double margin_m);

  // Points asked for in turn should be near each other: the edge that left the last one out is
  // looked at first.
  [[nodiscard]] bool operator()(double x_m, double y_m);

 private:
  struct Edge {
    double x_m, y_m;  // where it begins
    double dx_m, dy_m;
    double limit;  // of the cross product
  };

  std::vector<Edge> edges_;
  std::size_t last_ = 0;  // of edges, that left a point out
  double middle_x_m_ = 0;
  double middle_y_m_ = 0;
  double squared_radius_m2_ = -1;  // points nearer to the middle certainly are within
};

}  // namespace deepslam::segment
