#include "deepslam/shape/partial_view.h"

#include <cmath>
#include <cstddef>
#include <utility>

namespace deepslam::shape {
namespace {

constexpr auto kVoxel = static_cast<float>(kVoxelSize);

// Whether solid lies between a place just above the surface and a camera far away along
// `direction`.
bool Occluded(const SolidBits& solid,
              const Eigen::Vector3f& start,
              const Eigen::Vector3f& direction) {
  constexpr float kBlind = 1.2F;  // voxels: the stairs of a slanted face do not hide one another
  constexpr float kStep = 0.5F;   // voxels
  constexpr float kGrid = kGridSize;
  const Eigen::Vector3f step = kStep * direction;
  // Voxel units, the grid's corner being 0.
  Eigen::Vector3f at =
      start / kVoxel + Eigen::Vector3f::Constant(0.5F * kGrid) + kBlind * direction;
  while (at.x() >= 0 && at.y() >= 0 && at.z() >= 0 && at.x() < kGrid && at.y() < kGrid &&
         at.z() < kGrid) {
    if (solid.At(static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z())))
      return true;
    at += step;
  }
  return false;
}

// Whether the camera sees one of the free faces of the surface point's voxel. The voxel's own faces
// decide, not the normal, which is smoothed over a few voxels and leans at rims.
bool IsSeen(const SolidBits& solid,
            const Eigen::Vector3f& point,
            const Eigen::Vector3f& normal,
            const Eigen::Vector3f& direction) {
  constexpr float kGrazing = 0.02F;  // cosine; about 1 degree
  // Starting in the free layer above the face keeps a flat face from hiding itself at grazing
  // angles.
  constexpr float kLift = 0.8F * kVoxel;
  if (normal.dot(direction) < -kGrazing) return false;
  const Eigen::Vector3f center = point - 0.5F * kVoxel * normal;
  const Eigen::Array3i voxel = (center.array() / kVoxel + 0.5F * kGridSize).floor().cast<int>();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(direction[axis]) < kGrazing) continue;
    const int side = direction[axis] > 0 ? 1 : -1;
    Eigen::Array3i next = voxel;
    next[axis] += side;
    const bool inside = VoxelGrid::Contains(next.x(), next.y(), next.z());
    if (inside && solid.At(next.x(), next.y(), next.z())) continue;
    Eigen::Vector3f start = center;
    start[axis] += static_cast<float>(side) * kLift;
    if (!Occluded(solid, start, direction)) return true;
  }
  return false;
}

}  // namespace

PartialView::PartialView(const ShapeModel& model, double azimuth_rad, double elevation_rad)
    : PartialView(
          model, std::make_shared<const SolidBits>(model.grid()), azimuth_rad, elevation_rad) {}

PartialView::PartialView(const ShapeModel& model,
                         std::shared_ptr<const SolidBits> solid,
                         double azimuth_rad,
                         double elevation_rad)
    : model_(model),
      solid_(std::move(solid)),
      direction_(Eigen::Vector3d(std::cos(elevation_rad) * std::cos(azimuth_rad),
                                 std::cos(elevation_rad) * std::sin(azimuth_rad),
                                 std::sin(elevation_rad))
                     .cast<float>()) {}

bool PartialView::Shows(std::size_t n) const {
  return IsSeen(*solid_, model_.surface_points()[n], model_.surface_normals()[n], direction_);
}

}  // namespace deepslam::shape
