#include "deepslam/propose/coarse_shape.h"

#include <cstddef>
#include <cstdint>

#include "deepslam/core/every_nth.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::propose {
namespace {

constexpr int kSize = CoarseShape::kSize;
// Of thousands of surface points: enough to rank fits, each of which asks for all of them.
constexpr std::size_t kSurfaceSample = 400;

std::size_t Index(int i, int j, int k) {
  return (static_cast<std::size_t>(i) * kSize + static_cast<std::size_t>(j)) * kSize +
         static_cast<std::size_t>(k);
}

Eigen::Vector3f CellCenter(int i, int j, int k) {
  return (Eigen::Array3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)) +
          0.5F) /
             kSize -
         0.5F;
}

// Cells that hold something solid and have a free neighbour.
std::vector<Eigen::Vector3f> OuterCells(const VoxelGrid& grid) {
  std::vector<std::uint8_t> solid(static_cast<std::size_t>(kSize) * kSize * kSize, 0);
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k)
        solid[Index(i / 2, j / 2, k / 2)] |= grid.occupied[VoxelGrid::Index(i, j, k)];
    }
  }
  const auto is_solid = [&](int i, int j, int k) {
    return i >= 0 && j >= 0 && k >= 0 && i < kSize && j < kSize && k < kSize &&
           solid[Index(i, j, k)] != 0;
  };
  std::vector<Eigen::Vector3f> outer;
  for (int i = 0; i < kSize; ++i) {
    for (int j = 0; j < kSize; ++j) {
      for (int k = 0; k < kSize; ++k) {
        if (!is_solid(i, j, k)) continue;
        const bool enclosed = is_solid(i - 1, j, k) && is_solid(i + 1, j, k) &&
                              is_solid(i, j - 1, k) && is_solid(i, j + 1, k) &&
                              is_solid(i, j, k - 1) && is_solid(i, j, k + 1);
        if (!enclosed) outer.push_back(CellCenter(i, j, k));
      }
    }
  }
  return outer;
}

}  // namespace

CoarseShape::CoarseShape(const VoxelGrid& grid) {
  const shape::ShapeModel model(grid);
  if (model.empty()) return;
  extent_ = model.extent();
  solid_ = OuterCells(grid);
  field_.resize(static_cast<std::size_t>(kSize) * kSize * kSize);
  for (int i = 0; i < kSize; ++i) {
    for (int j = 0; j < kSize; ++j) {
      for (int k = 0; k < kSize; ++k) {
        field_[Index(i, j, k)] = model.Distance(CellCenter(i, j, k));
      }
    }
  }
  surface_ = EvenlySpaced(model.surface_points(), kSurfaceSample);
}

}  // namespace deepslam::propose
