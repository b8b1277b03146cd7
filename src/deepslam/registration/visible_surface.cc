#include "deepslam/registration/visible_surface.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "deepslam/shape/partial_view.h"

namespace deepslam::registration {
namespace {

constexpr double kStepRad = std::numbers::pi / 12;
constexpr int kAzimuths = 24;

// Cells along an axis, with one beyond either end for points on the cube's very rim.
constexpr int kCells = kGridSize / VisibleSurface::kCellVoxels + 2;

// A cell keeps one point per main direction of the normals in it, so that a thin plate keeps its
// edges.
std::size_t CellOf(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) {
  const Eigen::Array3i cell = ((point.array() + 0.5f) * static_cast<float>(kGridSize) /
                               static_cast<float>(VisibleSurface::kCellVoxels))
                                  .floor()
                                  .cast<int>() +
                              1;
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return static_cast<std::size_t>(((cell.x() * kCells + cell.y()) * kCells + cell.z()) * 3 +
                                  static_cast<int>(axis));
}

// The first visible point of each cell.
std::vector<SurfacePoint> ThinnedView(const shape::ShapeModel& model,
                                      double azimuth_rad,
                                      double elevation_rad) {
  const shape::PartialView camera(model, azimuth_rad, elevation_rad);
  std::vector<SurfacePoint> view;
  std::vector<bool> taken(std::size_t{kCells} * kCells * kCells * 3, false);
  for (std::size_t n = 0; n < model.surface_points().size(); ++n) {
    const Eigen::Vector3f& point = model.surface_points()[n];
    const Eigen::Vector3f& normal = model.surface_normals()[n];
    const std::size_t cell = CellOf(point, normal);
    if (taken[cell] || !camera.Shows(n)) continue;
    taken[cell] = true;
    view.push_back({point.cast<double>(), normal.cast<double>()});
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
