#include "deepslam/shape/shape_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "deepslam/geometry/trilinear.h"
#include "deepslam/shape/distance_transform.h"

namespace deepslam::shape {
namespace {

constexpr auto kVoxel = static_cast<float>(kVoxelSize);
constexpr float kEmptyDistance = 10.0F;  // beyond any point of a scene in object units
constexpr std::array<std::array<int, 3>, 6> kFaceNeighbours = {
    {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};

bool Occupied(const VoxelGrid& grid, int i, int j, int k) {
  return VoxelGrid::Contains(i, j, k) && grid.At(i, j, k);
}

std::vector<float> SignedField(const VoxelGrid& grid) {
  const std::vector<float> to_occupied = SquaredDistanceTo(grid, true);
  const std::vector<float> to_free = SquaredDistanceTo(grid, false);
  std::vector<float> field(grid.occupied.size());
  for (std::size_t n = 0; n < field.size(); ++n) {
    // The boundary lies half a voxel from the centres on its both sides.
    const float voxels =
        grid.occupied[n] != 0 ? 0.5F - std::sqrt(to_free[n]) : std::sqrt(to_occupied[n]) - 0.5F;
    field[n] = std::clamp(voxels * kVoxel, -kEmptyDistance, kEmptyDistance);
  }
  return field;
}

// Binomial blur (1 4 6 4 1)/16 along each axis; voxels beyond the cube are free.
std::vector<float> Blurred(const VoxelGrid& grid) {
  std::vector<float> values(grid.occupied.begin(), grid.occupied.end());
  constexpr std::array<float, 5> kWeights = {1 / 16.0F, 4 / 16.0F, 6 / 16.0F, 4 / 16.0F, 1 / 16.0F};
  constexpr std::array<std::size_t, 3> kStride = {1, kGridSize, kGridSize * kGridSize};
  std::array<float, kGridSize + 4> line{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t a = 0; a < kGridSize; ++a) {
      for (std::size_t b = 0; b < kGridSize; ++b) {
        float* const first =
            values.data() + a * kStride[(axis + 1) % 3] + b * kStride[(axis + 2) % 3];
        for (std::size_t n = 0; n < kGridSize; ++n) line[n + 2] = first[n * kStride[axis]];
        for (std::size_t n = 0; n < kGridSize; ++n) {
          float sum = 0;
          for (std::size_t w = 0; w < 5; ++w) sum += kWeights[w] * line[n + w];
          first[n * kStride[axis]] = sum;
        }
      }
    }
  }
  return values;
}

Eigen::Vector3f OutwardGradient(const std::vector<float>& blurred, int i, int j, int k) {
  const auto at = [&](int x, int y, int z) {
    return VoxelGrid::Contains(x, y, z) ? blurred[VoxelGrid::Index(x, y, z)] : 0.0F;
  };
  return -Eigen::Vector3f(at(i + 1, j, k) - at(i - 1, j, k),
                          at(i, j + 1, k) - at(i, j - 1, k),
                          at(i, j, k + 1) - at(i, j, k - 1));
}

}  // namespace

ShapeModel::ShapeModel(const VoxelGrid& grid) : grid_(grid), field_(SignedField(grid)) {
  // A flat face of a solid gives a gradient of 10/16, both sides of a plate one voxel thin cancel
  // to 0.
  constexpr float kClearGradient = 0.12F;
  const std::vector<float> blurred = Blurred(grid);
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        if (!grid.At(i, j, k)) continue;
        const Eigen::Vector3f center = VoxelGrid::Center(i, j, k).cast<float>();
        const Eigen::Vector3f outward = OutwardGradient(blurred, i, j, k);
        bool exposed = false;
        for (const auto& [di, dj, dk] : kFaceNeighbours) {
          if (Occupied(grid, i + di, j + dj, k + dk)) continue;
          exposed = true;
          if (outward.norm() >= kClearGradient) break;
          const Eigen::Vector3f side = Eigen::Vector3i(di, dj, dk).cast<float>();
          points_.emplace_back(center + 0.5F * kVoxel * side);
          normals_.push_back(side);
        }
        if (exposed && outward.norm() >= kClearGradient) {
          points_.emplace_back(center + 0.5F * kVoxel * outward.normalized());
          normals_.push_back(outward.normalized());
        }
      }
    }
  }
  const std::optional<VoxelBox> box = OccupiedBox(grid);
  if (!box) return;
  box_min_ = box->low.cast<float>() * kVoxel - 0.5F;
  box_max_ = (box->high + 1).cast<float>() * kVoxel - 0.5F;
}

ShapeModel::Sample ShapeModel::SampleInside(const Eigen::Vector3f& p_object) const {
  const Eigen::Array3f voxel = (p_object.array() + 0.5F) * static_cast<float>(kGridSize) - 0.5F;
  // Rounded down by the cast, as nothing inside is negative by more than rounding.
  const Eigen::Array3i base = voxel.cast<int>().max(0).min(kGridSize - 2);
  const Eigen::Array3f t = voxel - base.cast<float>();
  const TrilinearSample sample =
      SampleTrilinear(field_.data() + VoxelGrid::Index(base.x(), base.y(), base.z()),
                      std::size_t{kGridSize} * kGridSize,
                      kGridSize,
                      t);
  return {sample.value, sample.gradient * static_cast<float>(kGridSize)};
}

ShapeModel::Sample ShapeModel::At(const Eigen::Vector3f& p_object) const {
  constexpr float kLimit = 0.5F - 0.5F * kVoxel;  // centres of the outermost voxels
  const bool is_inside = std::abs(p_object.x()) <= kLimit && std::abs(p_object.y()) <= kLimit &&
                         std::abs(p_object.z()) <= kLimit;  // false for NaN
  if (is_inside) return SampleInside(p_object);
  if (empty() || !p_object.allFinite()) return {kEmptyDistance, Eigen::Vector3f::Zero()};
  const Eigen::Vector3f inside = p_object.cwiseMax(-kLimit).cwiseMin(kLimit);
  const Sample sample = SampleInside(inside);
  // Beyond the cube: distance to the surface point nearest to the cube's rim.
  const float length = std::max(sample.gradient.norm(), 1e-6F);
  const Eigen::Vector3f nearest = inside - sample.distance / length * sample.gradient;
  const Eigen::Vector3f away = p_object - nearest;
  return {away.norm(), away.normalized()};
}

}  // namespace deepslam::shape
