#include "deepslam/scene/layout.h"

#include <cstddef>

namespace deepslam {

std::string_view NameOf(OpeningKind kind) {
  switch (kind) {
    case OpeningKind::kDoor:
      return "door";
    case OpeningKind::kWindow:
      return "window";
    case OpeningKind::kPassage:
      break;
  }
  return "passage";
}

double AreaOf(const std::vector<Eigen::Vector2d>& polygon_m) {
  double doubled = 0;
  for (std::size_t i = 0; i < polygon_m.size(); ++i) {
    const Eigen::Vector2d& a = polygon_m[i];
    const Eigen::Vector2d& b = polygon_m[(i + 1) % polygon_m.size()];
    doubled += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * doubled;
}

bool IsInside(const std::vector<Eigen::Vector2d>& polygon_m, const Eigen::Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon_m.size(); ++i) {
    const Eigen::Vector2d& a = polygon_m[i];
    const Eigen::Vector2d& b = polygon_m[(i + 1) % polygon_m.size()];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const double crossing = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (point.x() < crossing) inside = !inside;
  }
  return inside;
}

}  // namespace deepslam
