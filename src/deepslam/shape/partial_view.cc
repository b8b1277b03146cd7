#include "deepslam/shape/partial_view.h"

#include <cmath>
#include <cstddef>

namespace deepslam::shape {
namespace {

constexpr auto kVoxel = static_cast<float>(kVoxelSize);

// Whether solid lies between a surface point and a camera far away along `direction`.
bool Occluded(const VoxelGrid& grid,
              const Eigen::Vector3f& point,
              const Eigen::Vector3f& normal,
              const Eigen::Vector3f& direction) {
  // Starting in the free layer above the surface keeps a flat face from hiding itself at grazing
  // angles; stairs of slanted faces reach a voxel further.
  constexpr float kLift = 0.3F * kVoxel;
  constexpr float kBlind = 1.2F * kVoxel;
  constexpr float kStep = 0.5F * kVoxel;
  const Eigen::Vector3f start = point + kLift * normal;
  for (float t = kBlind;; t += kStep) {
    const Eigen::Array3i voxel =
        ((start + t * direction).array() / kVoxel + 0.5F * kGridSize).floor().cast<int>();
    if (!VoxelGrid::Contains(voxel.x(), voxel.y(), voxel.z())) return false;
    if (grid.At(voxel.x(), voxel.y(), voxel.z())) return true;
  }
}

}  // namespace

std::vector<Eigen::Vector3f> PartialView(const ShapeModel& model,
                                         double azimuth_rad,
                                         double elevation_rad) {
  const Eigen::Vector3f direction = Eigen::Vector3d(std::cos(elevation_rad) * std::cos(azimuth_rad),
                                                    std::cos(elevation_rad) * std::sin(azimuth_rad),
                                                    std::sin(elevation_rad))
                                        .cast<float>();
  constexpr float kGrazing = 0.02F;  // cosine; about 1 degree
  std::vector<Eigen::Vector3f> visible;
  for (std::size_t n = 0; n < model.surface_points().size(); ++n) {
    const Eigen::Vector3f& normal = model.surface_normals()[n];
    if (normal.dot(direction) < kGrazing) continue;
    const Eigen::Vector3f& point = model.surface_points()[n];
    if (!Occluded(model.grid(), point, normal, direction)) visible.push_back(point);
  }
  return visible;
}

}  // namespace deepslam::shape
