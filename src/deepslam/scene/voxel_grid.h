// A model's shape: 64^3 binary occupancy of the unit cube of its object frame.
//
// Object frame: z up, x front, origin at the cube's centre, the cube is [-0.5, 0.5]^3. The model's
// bounding box is centred and its longest side is kModelExtent (62 voxels), so that one free voxel
// stays around it. Voxel (i, j, k) along x, y, z has its centre at ((i, j, k) + 0.5) / 64 - 0.5.
// Storage: index (i * 64 + j) * 64 + k.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace deepslam {

inline constexpr int kGridSize = 64;  // voxels along an axis, as the networks give them
inline constexpr double kVoxelSize = 1.0 / kGridSize;     // object units
inline constexpr double kModelExtent = 62.0 / kGridSize;  // longest side of a model, object units

struct VoxelGrid {
  std::vector<std::uint8_t> occupied = std::vector<std::uint8_t>(
      static_cast<std::size_t>(kGridSize) * kGridSize * kGridSize, 0);  // 0 or 1

  static std::size_t Index(int i, int j, int k) {
    return (static_cast<std::size_t>(i) * kGridSize + static_cast<std::size_t>(j)) * kGridSize +
           static_cast<std::size_t>(k);
  }
  static bool Contains(int i, int j, int k) {
    return i >= 0 && j >= 0 && k >= 0 && i < kGridSize && j < kGridSize && k < kGridSize;
  }
  [[nodiscard]] bool At(int i, int j, int k) const { return occupied[Index(i, j, k)] != 0; }
  static Eigen::Vector3d Center(int i, int j, int k) {
    return (Eigen::Vector3d(i, j, k).array() + 0.5) * kVoxelSize - 0.5;
  }
  friend bool operator==(const VoxelGrid&, const VoxelGrid&) = default;
};

// Box of the occupied voxels, both corners within it.
struct VoxelBox {
  Eigen::Array3i low;
  Eigen::Array3i high;

  [[nodiscard]] Eigen::Array3i sides() const { return high - low + 1; }
};

// Nothing where no voxel is occupied.
std::optional<VoxelBox> OccupiedBox(const VoxelGrid& grid);

}  // namespace deepslam
