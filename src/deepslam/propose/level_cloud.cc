#include "deepslam/propose/level_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <vector>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/parallel.h"
#include "deepslam/geometry/upright.h"
#include "deepslam/shape/view_points.h"

namespace deepslam::propose {
namespace {

constexpr int kPointsPerView = 3000;  // at one a cell nearly two square metres of surface
// Share of cells below the bottom where no ground was seen: strays of segments that leak.
constexpr double kBelowBottomShare = 0.01;
constexpr std::size_t kMinCells = 30;  // cells; fewer bound no box

struct CellSum {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float count = 0;
  int num_views = 0;
  std::size_t last_view = SIZE_MAX;
};

}  // namespace

LevelFrame FindLevel(std::span<const ObjectView> views) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  Eigen::Vector3d camera_up = Eigen::Vector3d::Zero();
  std::vector<Plane> planes;
  for (const ObjectView& view : views) {
    const Eigen::Vector3d down_camera = Turned(Eigen::Vector3d(0, 1, 0), Inverse(view.upright));
    camera_up -= view.world_from_camera.rotation * down_camera;
    if (!view.ground_camera) continue;
    planes.push_back(Transformed(view.world_from_camera, *view.ground_camera));
    up += planes.back().normal;
  }
  LevelFrame level;
  level.has_ground = !planes.empty() && up.norm() > 1e-6;
  if (!level.has_ground) up = camera_up;
  if (up.norm() < 1e-6) up = -Eigen::Vector3d::UnitY();
  level.level_from_world.rotation = ShortestRotation(up.normalized(), Eigen::Vector3d::UnitZ());
  if (level.has_ground) {
    std::vector<double> heights;
    for (const Plane& plane : planes) heights.push_back(plane.d_m);
    level.level_from_world.translation_m.z() = Median(heights);
  }
  return level;
}

LevelCloud AccumulateLevel(std::span<const ObjectView> views) {
  const LevelFrame level = FindLevel(views);
  LevelCloud cloud;
  cloud.level_from_world = level.level_from_world;
  cloud.has_ground = level.has_ground;
  std::map<std::array<int, 3>, CellSum> cells;
  double distance_sum_m = 0;
  double num_points = 0;
  std::size_t num_views = 0;
  std::vector<shape::ViewPoints> of_views(views.size());
  ParallelFor(views.size(), [&](std::size_t v) {
    of_views[v] = shape::ExtractViewPoints(views[v], kPointsPerView);
  });
  for (std::size_t v = 0; v < views.size(); ++v) {
    const shape::ViewPoints& points = of_views[v];
    if (points.points_camera.empty()) continue;
    ++num_views;
    const Pose3 level_from_camera = level.level_from_world * views[v].world_from_camera;
    for (const Eigen::Vector3f& p_camera : points.points_camera) {
      const Eigen::Vector3f p_level = (level_from_camera * p_camera.cast<double>()).cast<float>();
      const Eigen::Array3i key = (p_level.array() / kCloudCell_m).floor().cast<int>();
      CellSum& cell = cells[{key.x(), key.y(), key.z()}];
      cell.sum += p_level;
      cell.count += 1;
      if (cell.last_view != v) ++cell.num_views;
      cell.last_view = v;
      distance_sum_m += p_camera.norm();
      num_points += 1;
    }
  }
  // With several views, what a single one saw is as likely a stray as a rarely seen part: a tenth
  // of them must agree.
  const int min_views = num_views < 4 ? 1 : std::max(2, static_cast<int>(num_views) / 10);
  for (const auto& [key, cell] : cells) {
    if (cell.num_views >= min_views) cloud.points.emplace_back(cell.sum / cell.count);
  }
  if (cloud.points.size() < kMinCells) cloud.points.clear();
  if (num_points > 0) cloud.mean_distance_m = distance_sum_m / num_points;
  if (!cloud.has_ground && !cloud.points.empty()) {
    std::vector<float> heights;
    for (const Eigen::Vector3f& p : cloud.points) heights.push_back(p.z());
    const double bottom_m = Quantile(heights, kBelowBottomShare);
    cloud.level_from_world.translation_m.z() -= bottom_m;
    for (Eigen::Vector3f& p : cloud.points) p.z() -= static_cast<float>(bottom_m);
  }
  return cloud;
}

LevelCloud CloudOf(const ObjectObservations& object) {
  return object.cloud != nullptr ? *object.cloud : AccumulateLevel(object.views);
}

std::vector<std::size_t> ChooseViews(std::span<const ObjectView> views,
                                     const Eigen::Vector3d& center_world,
                                     int max_views) {
  std::vector<double> support(views.size(), 0.0);
  std::vector<Eigen::Vector3d> directions(views.size());
  for (std::size_t n = 0; n < views.size(); ++n) {
    const Mask& mask = views[n].mask_crop;
    const auto pixels =
        static_cast<double>(std::count_if(mask.begin(), mask.end(), [](auto m) { return m != 0; }));
    support[n] = pixels * (views[n].touches_border ? 0.5 : 1.0) * (0.2 + views[n].detection_score);
    directions[n] = (views[n].world_from_camera.translation_m - center_world).normalized();
  }
  std::vector<std::size_t> chosen;
  std::vector<double> spread(views.size(), 1.0);  // chord to the nearest chosen direction
  while (chosen.size() < views.size() && static_cast<int>(chosen.size()) < max_views) {
    std::size_t best = views.size();
    double best_value = 0;
    for (std::size_t n = 0; n < views.size(); ++n) {
      const double value = std::sqrt(support[n]) * spread[n];
      if (value > best_value) {
        best_value = value;
        best = n;
      }
    }
    if (best == views.size()) break;
    chosen.push_back(best);
    for (std::size_t n = 0; n < views.size(); ++n) {
      spread[n] = std::min(spread[n], (directions[n] - directions[best]).norm());
    }
    spread[best] = 0;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace deepslam::propose
