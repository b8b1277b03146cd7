#include "deepslam/instances/upright_box.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

namespace deepslam::instances {
namespace {

constexpr int kNumYaws = 30;            // of a quarter turn: 3 degrees apart
constexpr double kLeftOutShare = 0.01;  // of the points, at either end of a side
// A flat set of points has a least rectangle as well.
constexpr double kAddedToSidesM = 0.02;

}  // namespace

Eigen::Vector2d UprightBox::long_axis() const {
  const double turned_rad = length_m > width_m ? yaw_rad : yaw_rad + 0.5 * std::numbers::pi;
  return {std::cos(turned_rad), std::sin(turned_rad)};
}

LevelRectangle OutlineOf(const UprightBox& box, double margin_m) {
  return {box.centre_m, box.yaw_rad, box.length_m + 2 * margin_m, box.width_m + 2 * margin_m};
}

std::pair<double, double> ExtentOf(std::vector<double>& values) {
  const auto left_out =
      static_cast<std::ptrdiff_t>(kLeftOutShare * static_cast<double>(values.size() - 1));
  const auto low = values.begin() + left_out;
  const auto high = values.end() - 1 - left_out;
  std::nth_element(values.begin(), low, values.end());
  const double lowest = *low;
  std::nth_element(values.begin(), high, values.end());
  return {lowest, *high};
}

UprightBox BoxOf(std::span<const Eigen::Vector3f> points) {
  UprightBox best;
  if (points.empty()) return best;
  double least_m2 = std::numeric_limits<double>::infinity();
  std::vector<double> along(points.size());
  for (int n = 0; n < kNumYaws; ++n) {
    const double yaw_rad = n * (std::numbers::pi / 2) / kNumYaws;
    const Eigen::Vector2d x_axis(std::cos(yaw_rad), std::sin(yaw_rad));
    const Eigen::Vector2d y_axis(-x_axis.y(), x_axis.x());
    const auto extent = [&](const Eigen::Vector2d& axis) {
      for (std::size_t i = 0; i < points.size(); ++i)
        along[i] = axis.dot(points[i].head<2>().cast<double>());
      return ExtentOf(along);
    };
    const auto [x_low, x_high] = extent(x_axis);
    const auto [y_low, y_high] = extent(y_axis);
    const double area_m2 = (x_high - x_low + kAddedToSidesM) * (y_high - y_low + kAddedToSidesM);
    if (area_m2 >= least_m2) continue;
    least_m2 = area_m2;
    best.yaw_rad = yaw_rad;
    best.length_m = x_high - x_low;
    best.width_m = y_high - y_low;
    best.centre_m = 0.5 * (x_low + x_high) * x_axis + 0.5 * (y_low + y_high) * y_axis;
  }
  for (std::size_t i = 0; i < points.size(); ++i) along[i] = points[i].z();
  std::tie(best.bottom_m, best.top_m) = ExtentOf(along);
  return best;
}

}  // namespace deepslam::instances
