#include "deepslam/eval/placed_iou.h"

#include <cmath>
#include <cstdint>

#include "deepslam/geometry/box.h"

namespace deepslam::eval {
namespace {

constexpr int kStepsAlong = 128;  // samples along the longest side; a model's grid has half as many

Box3 WorldBox(const VoxelGrid& grid, const Similarity3& world_from_grid) {
  Box3 box;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        if (grid.At(i, j, k)) box.Extend(world_from_grid * VoxelGrid::Center(i, j, k));
      }
    }
  }
  if (box.empty()) return box;
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(world_from_grid.scale * kVoxelSize);
  return {box.min - margin, box.max + margin};
}

bool Holds(const VoxelGrid& grid, const Eigen::Vector3d& p_grid) {
  const Eigen::Vector3d index = (p_grid.array() + 0.5) / kVoxelSize;
  if ((index.array() < 0).any() || (index.array() >= kGridSize).any()) return false;
  return grid.At(
      static_cast<int>(index.x()), static_cast<int>(index.y()), static_cast<int>(index.z()));
}

}  // namespace

double PlacedIou(const VoxelGrid& a,
                 const Similarity3& world_from_a,
                 const VoxelGrid& b,
                 const Similarity3& world_from_b) {
  Box3 box;
  for (const Box3& one : {WorldBox(a, world_from_a), WorldBox(b, world_from_b)}) {
    if (one.empty()) continue;
    box.Extend(one.min);
    box.Extend(one.max);
  }
  if (box.empty()) return 0;
  const Similarity3 a_from_world = world_from_a.Inverse();
  const Similarity3 b_from_world = world_from_b.Inverse();
  const double step = box.Size().maxCoeff() / kStepsAlong;
  const Eigen::Vector3i count = (box.Size() / step).array().ceil().cast<int>();
  std::int64_t both = 0;
  std::int64_t either = 0;
  for (int i = 0; i < count.x(); ++i) {
    for (int j = 0; j < count.y(); ++j) {
      for (int k = 0; k < count.z(); ++k) {
        const Eigen::Vector3d p =
            box.min + step * (Eigen::Vector3d(i, j, k).array() + 0.5).matrix();
        const bool in_a = Holds(a, a_from_world * p);
        const bool in_b = Holds(b, b_from_world * p);
        both += in_a && in_b ? 1 : 0;
        either += in_a || in_b ? 1 : 0;
      }
    }
  }
  return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 0;
}

Similarity3 MeshFromGrid(const TriangleMesh& mesh) {
  Box3 box;
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t n : face) box.Extend(mesh.vertices[n].cast<double>());
  }
  return {box.Size().maxCoeff() / kModelExtent, Eigen::Quaterniond::Identity(), box.Center()};
}

}  // namespace deepslam::eval
