#include "deepslam/scene/wall_geometry.h"

#include <algorithm>
#include <cstddef>

namespace deepslam {
namespace {

constexpr double kOpposite = -0.95;  // cosine between two faces of one wall, or less
constexpr double kCorner_m = 0.03;   // walls whose ends are this near meet
constexpr double kSharp = 0.5;       // sine: what turns by less than 30 degrees is no corner

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

Eigen::Vector2d AlongOf(const LayoutWall& wall) {
  const double length_m = wall.length_m();
  return length_m > 0 ? Eigen::Vector2d((wall.to_m - wall.from_m) / length_m)
                      : Eigen::Vector2d::UnitX();
}

double DistanceBefore(const LayoutWall& wall, const Eigen::Vector2d& p_m) {
  return Cross(AlongOf(wall), p_m - wall.from_m);
}

double DistanceTo(const LayoutWall& wall, const Eigen::Vector2d& p_m) {
  const double along_m = AlongOf(wall).dot(p_m - wall.from_m);
  const Eigen::Vector2d nearest_m =
      wall.from_m + std::clamp(along_m, 0.0, wall.length_m()) * AlongOf(wall);
  return (p_m - nearest_m).norm();
}

std::optional<double> ThicknessOf(const Layout& layout, const LayoutWall& wall) {
  const Eigen::Vector2d along = AlongOf(wall);
  std::optional<double> thickness_m;
  for (const LayoutWall& other : layout.walls) {
    if (along.dot(AlongOf(other)) > kOpposite) continue;
    const double behind_m = -DistanceBefore(wall, 0.5 * (other.from_m + other.to_m));
    const double first_m = along.dot(other.to_m - wall.from_m);
    const double last_m = along.dot(other.from_m - wall.from_m);
    if (behind_m <= 0 || behind_m > kThickestWall_m) continue;
    if (last_m <= 0 || first_m >= wall.length_m()) continue;
    thickness_m = std::min(thickness_m.value_or(behind_m), behind_m);
  }
  return thickness_m;
}

bool MeetsInHollowCorner(const Layout& layout, const LayoutWall& wall, bool at_end) {
  return std::any_of(layout.walls.begin(), layout.walls.end(), [&](const LayoutWall& other) {
    const double gap_m =
        at_end ? (other.from_m - wall.to_m).norm() : (other.to_m - wall.from_m).norm();
    const double turn = Cross(AlongOf(wall), AlongOf(other));
    return gap_m < kCorner_m && (at_end ? turn : -turn) > kSharp;
  });
}

std::pair<double, double> SpanOf(const LayoutOpening& opening, const LayoutWall& wall) {
  const double a = AlongOf(wall).dot(opening.from_m - wall.from_m);
  const double b = AlongOf(wall).dot(opening.to_m - wall.from_m);
  return {std::min(a, b), std::max(a, b)};
}

bool GoesThrough(const Layout& layout, const LayoutOpening& opening, const LayoutWall& wall) {
  const LayoutWall& of = layout.walls[static_cast<std::size_t>(opening.wall)];
  if (AlongOf(of).dot(AlongOf(wall)) > kOpposite) return false;
  const Eigen::Vector2d middle = 0.5 * (opening.from_m + opening.to_m);
  const double behind_m = -DistanceBefore(wall, middle);
  const double at_m = AlongOf(wall).dot(middle - wall.from_m);
  return behind_m > 0 && behind_m < kThickestWall_m && at_m > 0 && at_m < wall.length_m();
}

}  // namespace deepslam
