#include "deepslam/modelling/long_side.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

namespace deepslam::modelling {
namespace {

// Of 29 tables of the catalogues 23 are longer along y by more than a tenth, one along x.
constexpr double kLonger = 1.1;
// Of a wall's normal along the axis: within 45 degrees.
constexpr double kFaces = 0.7;

// The side of an axis through the middle, +1 or -1, that the nearest of the walls across it faces.
int SideOfTheRoom(std::span<const Plane> walls,
                  const Eigen::Vector3d& middle,
                  const Eigen::Vector3d& axis) {
  double nearest = std::numeric_limits<double>::infinity();
  int side = 1;
  for (const Plane& wall : walls) {
    const double distance = std::abs(wall.SignedDistance(middle));
    const double faces = wall.normal.dot(axis);
    if (std::abs(faces) < kFaces || distance >= nearest) continue;
    nearest = distance;
    side = faces > 0 ? 1 : -1;
  }
  return side;
}

// The grid seen from axes of which x lies along `side` times the former y.
VoxelGrid QuarterTurned(const VoxelGrid& grid, int side) {
  VoxelGrid turned;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      const int former_i = side > 0 ? kGridSize - 1 - j : j;
      const int former_j = side > 0 ? i : kGridSize - 1 - i;
      for (int k = 0; k < kGridSize; ++k)
        turned.occupied[VoxelGrid::Index(i, j, k)] = grid.At(former_i, former_j, k) ? 1 : 0;
    }
  }
  return turned;
}

}  // namespace

void FaceAcrossLongSide(std::span<const Plane> walls, refine::CompletedModel& model) {
  const std::optional<VoxelBox> box = OccupiedBox(model.grid);
  if (!box || box->sides().x() <= kLonger * box->sides().y()) return;
  const Similarity3& model_from_grid = model.model_from_grid;
  const int side = SideOfTheRoom(
      walls, model_from_grid.translation_m, model_from_grid.rotation * Eigen::Vector3d::UnitY());
  const Eigen::Quaterniond quarter(
      Eigen::AngleAxisd(side * 0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()));
  model.grid = QuarterTurned(model.grid, side);
  model.model_from_grid = model_from_grid * Similarity3{1.0, quarter};
}

}  // namespace deepslam::modelling
