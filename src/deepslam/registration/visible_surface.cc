#include "deepslam/registration/visible_surface.h"

#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

#include "deepslam/shape/partial_view.h"

namespace deepslam::registration {
namespace {

constexpr double kStepRad = std::numbers::pi / 12;
constexpr int kAzimuths = 24;

// A cell keeps one point per main direction of the normals in it, so that a thin plate keeps its
// edges.
std::tuple<int, int, int, int> CellOf(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) {
  const Eigen::Vector3i cell = ((point.array() + 0.5f) * static_cast<float>(kGridSize) /
                                static_cast<float>(VisibleSurface::kCellVoxels))
                                   .floor()
                                   .cast<int>();
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return {cell.x(), cell.y(), cell.z(), static_cast<int>(axis)};
}

std::vector<SurfacePoint> ThinnedView(const shape::ShapeModel& model,
                                      double azimuth_rad,
                                      double elevation_rad) {
  std::vector<SurfacePoint> view;
  std::set<std::tuple<int, int, int, int>> cells;
  std::size_t i = 0;
  for (const Eigen::Vector3f& visible : shape::PartialView(model, azimuth_rad, elevation_rad)) {
    while (i < model.surface_points().size() && model.surface_points()[i] != visible) ++i;
    if (i == model.surface_points().size()) break;
    const Eigen::Vector3f& normal = model.surface_normals()[i];
    if (!cells.insert(CellOf(visible, normal)).second) continue;
    view.push_back({visible.cast<double>(), normal.cast<double>()});
  }
  return view;
}

}  // namespace

const std::vector<SurfacePoint>& VisibleSurface::From(const Eigen::Vector3d& direction_object) {
  const double azimuth = std::atan2(direction_object.y(), direction_object.x());
  const double elevation =
      std::atan2(direction_object.z(), std::hypot(direction_object.x(), direction_object.y()));
  const int azimuth_step =
      (static_cast<int>(std::lround(azimuth / kStepRad)) + kAzimuths) % kAzimuths;
  const int elevation_step = static_cast<int>(std::lround(elevation / kStepRad));
  const auto [entry, is_new] =
      views_.try_emplace({azimuth_step, elevation_step}, std::vector<SurfacePoint>());
  if (is_new) {
    entry->second = ThinnedView(model_, azimuth_step * kStepRad, elevation_step * kStepRad);
  }
  return entry->second;
}

}  // namespace deepslam::registration
