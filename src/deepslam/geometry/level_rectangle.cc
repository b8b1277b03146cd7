#include "deepslam/geometry/level_rectangle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

namespace deepslam {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Counter-clockwise.
Polygon CornersOf(const LevelRectangle& rectangle) {
  constexpr std::array<std::array<double, 2>, 4> kCorners = {
      {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}};
  const Eigen::Rotation2Dd rotation(rectangle.yaw_rad);
  Polygon corners;
  for (const auto& [x, y] : kCorners) {
    const Eigen::Vector2d corner(x * rectangle.length_m, y * rectangle.width_m);
    corners.emplace_back(rotation * corner + rectangle.centre_m);
  }
  return corners;
}

double AreaOf(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    twice += Cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return 0.5 * twice;
}

// What of a convex polygon lies to the left of the line through a and b.
Polygon LeftOf(const Polygon& polygon, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const auto side = [&](const Eigen::Vector2d& p) { return Cross(b - a, p - a); };
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& p = polygon[i];
    const Eigen::Vector2d& q = polygon[(i + 1) % polygon.size()];
    const double side_p = side(p);
    const double side_q = side(q);
    if (side_p >= 0) kept.push_back(p);
    if ((side_p >= 0) != (side_q >= 0)) kept.emplace_back(p + side_p / (side_p - side_q) * (q - p));
  }
  return kept;
}

}  // namespace

bool LevelRectangle::Contains(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d own = Eigen::Rotation2Dd(-yaw_rad) * (p - centre_m);
  return std::abs(own.x()) <= length_m / 2 && std::abs(own.y()) <= width_m / 2;
}

// Sutherland and Hodgman 1974.
double SharedArea(const LevelRectangle& a, const LevelRectangle& b) {
  Polygon shared = CornersOf(a);
  const Polygon window = CornersOf(b);
  for (std::size_t i = 0; i < window.size() && !shared.empty(); ++i)
    shared = LeftOf(shared, window[i], window[(i + 1) % window.size()]);
  return std::max(0.0, AreaOf(shared));
}

LevelRectangle HullAlong(const LevelRectangle& a, const LevelRectangle& b) {
  const Eigen::Rotation2Dd world_from_a(a.yaw_rad);
  Eigen::AlignedBox2d box;
  for (const LevelRectangle& part : {a, b}) {
    for (const Eigen::Vector2d& corner : CornersOf(part))
      box.extend(world_from_a.inverse() * corner);
  }
  return {world_from_a * box.center(), a.yaw_rad, box.sizes().x(), box.sizes().y()};
}

}  // namespace deepslam
