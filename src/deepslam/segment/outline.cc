#include "deepslam/segment/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "deepslam/core/wide_vectors.h"

namespace deepslam::segment {
namespace {

double Cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
}

// Corners of an octagon among the points: counter-clockwise, some may be the same.
std::array<Eigen::Vector2d, 8> Octagon(const PlanarPoints& points) {
  constexpr std::size_t kEveryNth = 4;  // is as good
  std::array<Eigen::Vector2d, 8> corners;
  std::array<double, 8> farthest;
  farthest.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t n = 0; n < points.x_m.size(); n += kEveryNth) {
    const double x = points.x_m[n];
    const double y = points.y_m[n];
    const std::array<double, 8> along = {x, x + y, y, y - x, -x, -x - y, -y, x - y};
    for (std::size_t k = 0; k < along.size(); ++k) {
      if (along[k] <= farthest[k]) continue;
      farthest[k] = along[k];
      corners[k] = {x, y};
    }
  }
  return corners;
}

// Not certainly inside a polygon given by its edges.
struct OctagonEdges {
  std::array<double, 8> x_m, y_m, dx_m, dy_m, limit;
};

DEEPSLAM_WIDE_VECTORS void MarkOutside(const double* x_m,
                                       const double* y_m,
                                       std::size_t count,
                                       const OctagonEdges& edges,
                                       std::int64_t* outside) {
  for (std::size_t n = 0; n < count; ++n) {
    std::int64_t out = 0;
    for (std::size_t k = 0; k < 8; ++k) {
      const double cross =
          edges.dx_m[k] * (y_m[n] - edges.y_m[k]) - edges.dy_m[k] * (x_m[n] - edges.x_m[k]);
      out |= cross > edges.limit[k] ? 0 : 1;
    }
    outside[n] = out;
  }
}

// Leaves out most points that cannot be corners of the hull.
std::vector<Eigen::Vector2d> NearHull(const PlanarPoints& points) {
  constexpr double kClearly_m = 1e-6;  // farther inside than rounding reaches
  const std::array<Eigen::Vector2d, 8> corners = Octagon(points);
  OctagonEdges edges{};
  bool is_point = true;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Eigen::Vector2d step = corners[(k + 1) % corners.size()] - corners[k];
    is_point = is_point && step.isZero(0.0);
    edges.x_m[k] = corners[k].x();
    edges.y_m[k] = corners[k].y();
    edges.dx_m[k] = step.x();
    edges.dy_m[k] = step.y();
    // An edge without length says nothing.
    edges.limit[k] = step.norm() > 0 ? kClearly_m * step.norm() : -1.0;
  }
  std::vector<std::int64_t> outside(points.x_m.size(), 1);
  if (!is_point) {
    MarkOutside(points.x_m.data(), points.y_m.data(), outside.size(), edges, outside.data());
  }
  std::vector<Eigen::Vector2d> near;
  for (std::size_t n = 0; n < outside.size(); ++n) {
    if (outside[n] != 0) near.emplace_back(points.x_m[n], points.y_m[n]);
  }
  return near;
}

}  // namespace

// Andrew's monotone chain.
std::vector<Eigen::Vector2d> ConvexHull(const PlanarPoints& points) {
  std::vector<Eigen::Vector2d> near = NearHull(points);
  std::sort(near.begin(), near.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Eigen::Vector2d> hull;
  const auto add = [&hull](const Eigen::Vector2d& p, std::size_t keep) {
    while (hull.size() >= keep + 2 && Cross(hull[hull.size() - 2], hull.back(), p) <= 0) {
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const Eigen::Vector2d& p : near) add(p, 0);
  if (hull.empty()) return hull;
  const std::size_t lower = hull.size() - 1;
  for (auto p = near.rbegin(); p != near.rend(); ++p) add(*p, lower);
  hull.pop_back();
  return hull;
}

double DoubleArea(std::span<const Eigen::Vector2d> hull) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < hull.size(); ++i) sum += Cross(hull[0], hull[i], hull[i + 1]);
  return sum;
}

WithinHull::WithinHull(std::span<const Eigen::Vector2d> hull, double margin_m) {
  constexpr double kClearly_m = 1e-9;  // more than rounding
  const std::size_t n = hull.size();
  if (n < 3) return;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : hull) middle += corner / static_cast<double>(n);
  double radius_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d& a = hull[i];
    const Eigen::Vector2d& b = hull[(i + 1) % n];
    const double length_m = (b - a).norm();
    const double limit = -margin_m * length_m;
    edges_.push_back({a.x(), a.y(), (b - a).x(), (b - a).y(), limit});
    if (length_m > 0) radius_m = std::min(radius_m, (Cross(a, b, middle) - limit) / length_m);
  }
  middle_x_m_ = middle.x();
  middle_y_m_ = middle.y();
  if (radius_m > kClearly_m) squared_radius_m2_ = (radius_m - kClearly_m) * (radius_m - kClearly_m);
}

bool WithinHull::operator()(double x_m, double y_m) {
  const double from_middle_x_m = x_m - middle_x_m_;
  const double from_middle_y_m = y_m - middle_y_m_;
  if (from_middle_x_m * from_middle_x_m + from_middle_y_m * from_middle_y_m < squared_radius_m2_) {
    return true;
  }
  const auto outside = [&](const Edge& edge) {
    return edge.dx_m * (y_m - edge.y_m) - edge.dy_m * (x_m - edge.x_m) < edge.limit;
  };
  if (edges_.empty() || outside(edges_[last_])) return false;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (!outside(edges_[i])) continue;
    last_ = i;
    return false;
  }
  return true;
}

}  // namespace deepslam::segment
