// Axis-aligned boxes in the image and in space.
#pragma once

#include <algorithm>
#include <limits>

#include <Eigen/Core>

namespace deepslam {

// Pixel rectangle, continuous coordinates, [u_min, u_max] x [v_min, v_max]; empty when a max is
// below its min.
struct Box2 {
  double u_min = 0;
  double v_min = 0;
  double u_max = -1;
  double v_max = -1;

  [[nodiscard]] bool empty() const { return u_max < u_min || v_max < v_min; }
  [[nodiscard]] double width_px() const { return std::max(0.0, u_max - u_min); }
  [[nodiscard]] double height_px() const { return std::max(0.0, v_max - v_min); }
  [[nodiscard]] double area_px() const { return width_px() * height_px(); }
  [[nodiscard]] bool Contains(double u, double v) const {
    return u >= u_min && u <= u_max && v >= v_min && v <= v_max;
  }
  friend bool operator==(const Box2&, const Box2&) = default;
};

[[nodiscard]] inline Box2 Intersection(const Box2& a, const Box2& b) {
  return {std::max(a.u_min, b.u_min),
          std::max(a.v_min, b.v_min),
          std::min(a.u_max, b.u_max),
          std::min(a.v_max, b.v_max)};
}

// Intersection over union, 0 when either is empty.
[[nodiscard]] inline double IntersectionOverUnion(const Box2& a, const Box2& b) {
  const double common = Intersection(a, b).area_px();
  const double both = a.area_px() + b.area_px() - common;
  return both > 0 ? common / both : 0.0;
}

struct Box3 {
  Eigen::Vector3d min = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d max = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());

  [[nodiscard]] bool empty() const { return (max.array() < min.array()).any(); }
  void Extend(const Eigen::Vector3d& point) {
    min = min.cwiseMin(point);
    max = max.cwiseMax(point);
  }
  [[nodiscard]] Eigen::Vector3d Size() const {
    return empty() ? Eigen::Vector3d::Zero().eval() : (max - min).eval();
  }
  [[nodiscard]] Eigen::Vector3d Center() const { return 0.5 * (min + max); }
};

}  // namespace deepslam
