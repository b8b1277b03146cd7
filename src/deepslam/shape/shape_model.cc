#include "deepslam/shape/shape_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "deepslam/core/wide_vectors.h"
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
  std::vector<float> field = SignedDistance(grid);
  for (float& distance : field)
    distance = std::clamp(distance * kVoxel, -kEmptyDistance, kEmptyDistance);
  return field;
}

// Binomial blur (1 4 6 4 1)/16 along each axis; voxels beyond the cube are free. Rows along k are
// worked on side by side.
DEEPSLAM_WIDE_VECTORS std::vector<float> Blurred(const VoxelGrid& grid) {
  constexpr std::array<float, 5> kWeights = {1 / 16.0F, 4 / 16.0F, 6 / 16.0F, 4 / 16.0F, 1 / 16.0F};
  std::vector<float> values(grid.occupied.begin(), grid.occupied.end());
  std::array<float, kGridSize + 4> line{};
  for (std::size_t r = 0; r < kGridSize * kGridSize; ++r) {
    float* const row = values.data() + r * kGridSize;
    for (std::size_t n = 0; n < kGridSize; ++n) line[n + 2] = row[n];
    for (std::size_t n = 0; n < kGridSize; ++n) {
      float sum = 0;
      for (std::size_t w = 0; w < 5; ++w) sum += kWeights[w] * line[n + w];
      row[n] = sum;
    }
  }
  std::array<std::array<float, kGridSize>, kGridSize + 4> rows{};
  for (const std::size_t stride : {std::size_t{kGridSize}, std::size_t{kGridSize} * kGridSize}) {
    const std::size_t other_stride = stride == kGridSize ? kGridSize * kGridSize : kGridSize;
    for (std::size_t a = 0; a < kGridSize; ++a) {
      float* const first = values.data() + a * other_stride;
      for (std::size_t r = 0; r < kGridSize; ++r)
        std::copy_n(first + r * stride, kGridSize, rows[r + 2].begin());
      for (std::size_t r = 0; r < kGridSize; ++r) {
        for (std::size_t n = 0; n < kGridSize; ++n) {
          float sum = 0;
          for (std::size_t w = 0; w < 5; ++w) sum += kWeights[w] * rows[r + w][n];
          first[r * stride + n] = sum;
        }
      }
    }
  }
  return values;
}

// From k on in the column; kGridSize where none is.
int NextOccupied(const VoxelGrid& grid, int i, int j, int k) {
  const std::uint8_t* const column = grid.occupied.data() + VoxelGrid::Index(i, j, 0);
  const void* const next = std::memchr(column + k, 1, static_cast<std::size_t>(kGridSize - k));
  return next == nullptr ? kGridSize
                         : static_cast<int>(static_cast<const std::uint8_t*>(next) - column);
}

// Whether one of the six neighbours is free.
bool IsExposed(const VoxelGrid& grid, int i, int j, int k) {
  return std::any_of(kFaceNeighbours.begin(), kFaceNeighbours.end(), [&](const auto& d) {
    return !Occupied(grid, i + d[0], j + d[1], k + d[2]);
  });
}

Eigen::Vector3f OutwardGradient(const std::vector<float>& blurred, int i, int j, int k) {
  const auto at = [&](int x, int y, int z) {
    return VoxelGrid::Contains(x, y, z) ? blurred[VoxelGrid::Index(x, y, z)] : 0.0F;
  };
  return -Eigen::Vector3f(at(i + 1, j, k) - at(i - 1, j, k),
                          at(i, j + 1, k) - at(i, j - 1, k),
                          at(i, j, k + 1) - at(i, j, k - 1));
}

Eigen::Array3f LowCorner(const VoxelBox& box) { return box.low.cast<float>() * kVoxel - 0.5F; }

}  // namespace

float BottomOf(const VoxelGrid& grid) {
  const std::optional<VoxelBox> box = OccupiedBox(grid);
  return box ? LowCorner(*box).z() : 0.0F;
}

ShapeModel::ShapeModel(const VoxelGrid& grid) : grid_(grid), field_(SignedField(grid)) {
  // A flat face of a solid gives a gradient of 10/16, both sides of a plate one voxel thin cancel
  // to 0.
  constexpr float kClearGradient = 0.12F;
  const std::vector<float> blurred = Blurred(grid);
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = NextOccupied(grid, i, j, 0); k < kGridSize;
           k = NextOccupied(grid, i, j, k + 1)) {
        if (!IsExposed(grid, i, j, k)) continue;
        const Eigen::Vector3f center = VoxelGrid::Center(i, j, k).cast<float>();
        const Eigen::Vector3f outward = OutwardGradient(blurred, i, j, k);
        if (outward.norm() >= kClearGradient) {
          points_.emplace_back(center + 0.5F * kVoxel * outward.normalized());
          normals_.push_back(outward.normalized());
          continue;
        }
        for (const auto& [di, dj, dk] : kFaceNeighbours) {
          if (Occupied(grid, i + di, j + dj, k + dk)) continue;
          const Eigen::Vector3f side = Eigen::Vector3i(di, dj, dk).cast<float>();
          points_.emplace_back(center + 0.5F * kVoxel * side);
          normals_.push_back(side);
        }
      }
    }
  }
  const std::optional<VoxelBox> box = OccupiedBox(grid);
  if (!box) return;
  box_min_ = LowCorner(*box);
  box_max_ = (box->high + 1).cast<float>() * kVoxel - 0.5F;
}

ShapeModel::Sample ShapeModel::BeyondCube(const Eigen::Vector3f& p_object) const {
  if (empty() || !p_object.allFinite()) return {kEmptyDistance, Eigen::Vector3f::Zero()};
  const Eigen::Vector3f inside = p_object.cwiseMax(-kInside).cwiseMin(kInside);
  const Sample sample = SampleInside(inside);
  const auto triple = [](const Eigen::Vector3f& v) { return Triple{v.x(), v.y(), v.z()}; };
  const FieldSample beyond =
      BeyondField(triple(inside), {sample.distance, triple(sample.gradient)}, triple(p_object));
  return {beyond.distance, {beyond.gradient.x, beyond.gradient.y, beyond.gradient.z}};
}

}  // namespace deepslam::shape
