#include "deepslam/layout/column_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "deepslam/layout/levels.h"

namespace deepslam::layout {
namespace {

// Free space in which people move; what is higher belongs to lamps, what is lower to feet.
constexpr double kFreeFrom_m = 0.2;
constexpr double kFreeTo_m = 2.0;      // heads of doors
constexpr double kSomeFree_m = 0.3;    // of a column: something was looked through,
constexpr double kMuchFree_m = 0.8;    // and enough for a person's upper body
constexpr float kOfMuchFree = 0.6F;    // of what a column says whose floor or ceiling was seen
constexpr float kOfSomeFree = 0.3F;    // half of that: windows are looked through too
constexpr float kNearlyLevel = 0.8F;   // least vertical part of a normal of floors and ceilings
constexpr double kFloorBand_m = 0.12;  // noise, carpets, thresholds

// The least rectangle of blocks; nothing where there are none.
ColumnMap EmptyMap(const ObservedSpace& space) {
  ColumnMap map;
  if (space.empty()) return map;
  Eigen::Vector2i low = space.blocks().front().index.head<2>();
  Eigen::Vector2i high = low;
  for (const SpaceBlock& block : space.blocks()) {
    low = low.cwiseMin(block.index.head<2>());
    high = high.cwiseMax(block.index.head<2>());
  }
  map.cell_m = space.voxel_m();
  map.origin_m = low.cast<double>() * (SpaceBlock::kSide * map.cell_m);
  map.width = (high.x() - low.x() + 1) * SpaceBlock::kSide;
  map.height = (high.y() - low.y() + 1) * SpaceBlock::kSide;
  const std::size_t size = map.IndexOf(map.width, 0);
  map.evidence.assign(size, 0);
  map.has_floor.assign(size, 0);
  return map;
}

// Per column, the number of free voxels that a person would move in.
std::vector<std::uint16_t> CountFree(const ObservedSpace& space, const ColumnMap& map) {
  constexpr int kSide = SpaceBlock::kSide;
  std::vector<std::uint16_t> num_free(map.evidence.size(), 0);
  const Eigen::Vector2i low = (map.origin_m / (kSide * map.cell_m)).array().round().cast<int>();
  for (const SpaceBlock& block : space.blocks()) {
    const double bottom_m = block.index.z() * kSide * map.cell_m;
    std::size_t voxel = 0;
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        const std::size_t column = map.IndexOf((block.index.x() - low.x()) * kSide + x,
                                               (block.index.y() - low.y()) * kSide + y);
        for (int z = 0; z < kSide; ++z, ++voxel) {
          const double at_m = bottom_m + (z + 0.5) * map.cell_m;
          if (at_m > kFreeFrom_m && at_m < kFreeTo_m && block.passed[voxel] > 0) ++num_free[column];
        }
      }
    }
  }
  return num_free;
}

// Marks the column of a point and those beside it.
void MarkAround(const Eigen::Vector3f& p, const ColumnMap& map, std::vector<std::uint8_t>& marks) {
  const Eigen::Array2d at = (p.head<2>().cast<double>() - map.origin_m).array() / map.cell_m;
  const int i = static_cast<int>(std::floor(at.x()));
  const int j = static_cast<int>(std::floor(at.y()));
  for (int di = -1; di <= 1; ++di) {
    for (int dj = -1; dj <= 1; ++dj) {
      if (i + di < 0 || i + di >= map.width || j + dj < 0 || j + dj >= map.height) continue;
      marks[map.IndexOf(i + di, j + dj)] = 1;
    }
  }
}

}  // namespace

ColumnMap MapColumns(const CoarseSurface& surface, const std::vector<double>& floors_m) {
  ColumnMap map = EmptyMap(surface.space);
  if (map.evidence.empty()) return map;
  std::vector<std::uint8_t> has_ceiling(map.evidence.size(), 0);
  for (std::size_t v = 0; v < surface.mesh.vertices.size(); ++v) {
    const Eigen::Vector3f& p = surface.mesh.vertices[v];
    const auto height_m = static_cast<double>(p.z());
    if (surface.normals[v].z() < -kNearlyLevel && height_m > kLowestCeiling_m)
      MarkAround(p, map, has_ceiling);
    if (surface.normals[v].z() < kNearlyLevel) continue;
    const bool is_floor = std::any_of(floors_m.begin(), floors_m.end(), [&](double floor_m) {
      return std::abs(height_m - floor_m) < kFloorBand_m;
    });
    if (is_floor) MarkAround(p, map, map.has_floor);
  }
  const std::vector<std::uint16_t> num_free = CountFree(surface.space, map);
  for (std::size_t n = 0; n < map.evidence.size(); ++n) {
    const double free_m = num_free[n] * map.cell_m;
    const bool bounded = map.has_floor[n] != 0 || has_ceiling[n] != 0;
    map.evidence[n] = free_m < kSomeFree_m   ? 0.0F
                      : bounded              ? 1.0F
                      : free_m > kMuchFree_m ? kOfMuchFree
                                             : kOfSomeFree;
  }
  return map;
}

}  // namespace deepslam::layout
