#include "deepslam/library/mirrored.h"

#include <cstddef>

#include "deepslam/core/parallel.h"
#include "deepslam/shape/distance_transform.h"

namespace deepslam::library {
namespace {

constexpr double kNearlyAll = 0.97;
constexpr float kNearSquared = 2.25F;  // voxels; legs one voxel thick may be rounded to either side

VoxelGrid MirroredShape(const VoxelGrid& shape) {
  VoxelGrid mirrored;
  for (int x = 0; x < kGridSize; ++x) {
    for (int y = 0; y < kGridSize; ++y) {
      for (int z = 0; z < kGridSize; ++z) {
        mirrored.occupied[VoxelGrid::Index(x, kGridSize - 1 - y, z)] =
            shape.occupied[VoxelGrid::Index(x, y, z)];
      }
    }
  }
  return mirrored;
}

}  // namespace

LibraryModel Mirrored(const LibraryModel& model) {
  LibraryModel mirrored = model;
  mirrored.id += "-mirrored";
  mirrored.name += " (mirrored)";
  mirrored.shape = MirroredShape(model.shape);
  mirrored.checksum.clear();
  return mirrored;
}

bool HasAHand(const VoxelGrid& shape) {
  const std::vector<float> squared_distance = shape::SquaredDistanceTo(shape, true);
  const VoxelGrid mirrored = MirroredShape(shape);
  std::size_t all = 0;
  std::size_t near = 0;
  for (std::size_t n = 0; n < mirrored.occupied.size(); ++n) {
    if (mirrored.occupied[n] == 0) continue;
    ++all;
    if (squared_distance[n] <= kNearSquared) ++near;
  }
  return static_cast<double>(near) < kNearlyAll * static_cast<double>(all);
}

void AddMirrored(std::vector<LibraryModel>& models) {
  std::vector<unsigned char> handed(models.size());
  ParallelFor(models.size(), [&](std::size_t n) { handed[n] = HasAHand(models[n].shape) ? 1 : 0; });
  for (std::size_t n = 0; n < handed.size(); ++n) {
    if (handed[n] != 0) models.push_back(Mirrored(models[n]));
  }
}

}  // namespace deepslam::library
