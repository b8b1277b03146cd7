#include "deepslam/registration/visible_surface.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>

#include "deepslam/shape/partial_view.h"

namespace deepslam::registration {
namespace {

// 15 degrees: what is seen hardly changes within.
constexpr double kStepRad = std::numbers::pi / 12;
constexpr int kAzimuths = 24;  // a full turn of kStepRad

// Cells along an axis, with one beyond either end for points on the cube's very rim.
constexpr int kCellsPerAxis = kGridSize / VisibleSurface::kCellVoxels + 2;
static_assert(kCellsPerAxis * kCellsPerAxis * kCellsPerAxis * 3 <=
              std::numeric_limits<std::uint16_t>::max());

// A cell keeps one point per main direction of the normals in it, so that a thin plate keeps its
// edges.
std::uint16_t CellOf(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) {
  const Eigen::Array3i cell = ((point.array() + 0.5f) * static_cast<float>(kGridSize) /
                               static_cast<float>(VisibleSurface::kCellVoxels))
                                  .floor()
                                  .cast<int>() +
                              1;
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return static_cast<std::uint16_t>(
      ((cell.x() * kCellsPerAxis + cell.y()) * kCellsPerAxis + cell.z()) * 3 +
      static_cast<int>(axis));
}

// The first visible point of each cell.
std::vector<SurfacePoint> ThinnedView(const shape::ShapeModel& model,
                                      const shape::PartialView& camera,
                                      std::span<const std::uint16_t> cell_of_point) {
  std::vector<SurfacePoint> view;
  std::vector<std::uint8_t> taken(std::size_t{kCellsPerAxis} * kCellsPerAxis * kCellsPerAxis * 3,
                                  0);
  for (std::size_t n = 0; n < cell_of_point.size(); ++n) {
    const std::size_t cell = cell_of_point[n];
    if (taken[cell] != 0 || !camera.Shows(n)) continue;
    taken[cell] = 1;
    view.push_back({model.surface_points()[n], model.surface_normals()[n]});
  }
  return view;
}

}  // namespace

void VisibleSurface::Prepare() {
  solid_ = std::make_shared<const shape::SolidBits>(model_.grid());
  for (std::size_t n = 0; n < model_.surface_points().size(); ++n)
    cell_of_point_.push_back(CellOf(model_.surface_points()[n], model_.surface_normals()[n]));
}

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
    if (!solid_) Prepare();
    const shape::PartialView camera(
        model_, solid_, azimuth_step * kStepRad, elevation_step * kStepRad);
    entry->second = ThinnedView(model_, camera, cell_of_point_);
  }
  return entry->second;
}

}  // namespace deepslam::registration
