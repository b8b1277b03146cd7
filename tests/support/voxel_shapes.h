// Furniture-like voxel grids with known geometry, in voxels from the grid's centre.
#pragma once

#include <cmath>
#include <cstddef>
#include <functional>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::testing_support {

// Occupied where `inside(x, y, z)` holds at a voxel's centre.
inline VoxelGrid FillGrid(const std::function<bool(double, double, double)>& inside) {
  VoxelGrid grid;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        const Eigen::Vector3d p = VoxelGrid::Center(i, j, k) / kVoxelSize;
        grid.occupied[VoxelGrid::Index(i, j, k)] = inside(p.x(), p.y(), p.z()) ? 1 : 0;
      }
    }
  }
  return grid;
}

inline int CountOccupied(const VoxelGrid& grid) {
  int count = 0;
  for (const auto voxel : grid.occupied) count += voxel != 0 ? 1 : 0;
  return count;
}

inline VoxelGrid Sphere(double radius) {
  return FillGrid(
      [=](double x, double y, double z) { return x * x + y * y + z * z < radius * radius; });
}

inline VoxelGrid Box(double half_x, double half_y, double half_z) {
  return FillGrid([=](double x, double y, double z) {
    return std::abs(x) < half_x && std::abs(y) < half_y && std::abs(z) < half_z;
  });
}

// Seat 2 voxels thick, back 2 voxels thick, four legs of one voxel.
inline VoxelGrid ChairWithThinLegs() {
  return FillGrid([](double x, double y, double z) {
    const bool seat = std::abs(x) < 14 && std::abs(y) < 14 && z > -2 && z < 0;
    const bool back = z > 0 && z < 31 && std::abs(y) < 14 && x < -12 && x > -14;
    const bool leg = z < -2 && z > -31 && std::abs(std::abs(x) - 12.5) < 0.6 &&
                     std::abs(std::abs(y) - 12.5) < 0.6;
    return seat || back || leg;
  });
}

// Round top 2 voxels thick on a column and a foot.
inline VoxelGrid RoundTable() {
  return FillGrid([](double x, double y, double z) {
    const double r = std::hypot(x, y);
    return (r < 31 && z > 10 && z < 12) || (r < 3 && z < 10 && z > -12) ||
           (r < 12 && z < -10 && z > -12);
  });
}

}  // namespace deepslam::testing_support
