#include "deepslam/library/alike.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "deepslam/library/furniture_library.h"
#include "deepslam/shape/distance_transform.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::library {
namespace {

constexpr double kAlikeIou = 0.9;  // IoU over 64^3 voxels, stretched to one size
// Legs and boards are one or two voxels thick: a different rounding halves their overlap. So shapes
// are alike as well when nearly all of each lies within a voxel of the other.
constexpr double kNearlyAllNear = 0.97;
constexpr float kNearSquared = 2.0F;  // diagonal neighbours in a plane
// A look at some voxels comes first; it passes whatever the whole comparison could.
constexpr std::size_t kSome = 400;
constexpr double kMostlyNear = 0.88;  // of those looked at; the whole comparison asks for more
constexpr double kRoughlyNear = 2.5;  // voxels: kNearSquared and the rounding of a stretched grid

// Sides of the occupied voxels' box, object units; zero when there are none.
Eigen::Vector3d Extent(const VoxelGrid& grid) {
  const std::optional<VoxelBox> box = OccupiedBox(grid);
  if (!box) return Eigen::Vector3d::Zero();
  return box->sides().cast<double>() * kVoxelSize;
}

// Share of a's voxels that lie within a voxel of the shape whose squared distances are given.
double ShareNear(const VoxelGrid& a, const std::vector<float>& squared_distance_b) {
  std::size_t near = 0;
  std::size_t all = 0;
  for (std::size_t n = 0; n < a.occupied.size(); ++n) {
    if (a.occupied[n] == 0) continue;
    ++all;
    near += squared_distance_b[n] <= kNearSquared ? 1U : 0U;
  }
  return all > 0 ? static_cast<double>(near) / static_cast<double>(all) : 0.0;
}

}  // namespace

ComparableShape::ComparableShape(const VoxelGrid& grid) : grid_(&grid), extent_(Extent(grid)) {
  if (extent_.minCoeff() <= 0) return;
  const auto count = std::count(grid.occupied.begin(), grid.occupied.end(), std::uint8_t{1});
  fullness_ = static_cast<double>(count) * kVoxelSize * kVoxelSize * kVoxelSize / extent_.prod();
  squared_distance_ = shape::SquaredDistanceTo(grid, true);
  const VoxelBox box = *OccupiedBox(grid);
  middle_ = box.low.cast<double>() + 0.5 * (box.sides().cast<double>() - 1);
  const std::size_t stride = 1 + static_cast<std::size_t>(count) / kSome;
  std::size_t seen = 0;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        if (!grid.At(i, j, k) || seen++ % stride != 0) continue;
        some_.push_back((Eigen::Array3d(i, j, k) - middle_) / box.sides().cast<double>());
      }
    }
  }
}

bool ComparableShape::LiesNear(const ComparableShape& b,
                               int quarter_turns,
                               const ComparableShape& a) {
  const Eigen::Array3d sides = a.extent_.array() / kVoxelSize;
  Eigen::Array3d sides_b = b.extent_.array() / kVoxelSize;
  if (quarter_turns % 2 != 0) std::swap(sides_b.x(), sides_b.y());
  // A voxel of b may be several of a.
  const double reach = kRoughlyNear * std::max(1.0, (sides / sides_b).maxCoeff());
  std::size_t near = 0;
  for (Eigen::Array3d p : b.some_) {
    for (int n = 0; n < quarter_turns; ++n) p = {-p.y(), p.x(), p.z()};
    const Eigen::Array3i at = (a.middle_ + p * sides).round().cast<int>().max(0).min(kGridSize - 1);
    const float squared = a.squared_distance_[VoxelGrid::Index(at.x(), at.y(), at.z())];
    near += squared <= reach * reach ? 1U : 0U;
  }
  return static_cast<double>(near) >= kMostlyNear * static_cast<double>(b.some_.size());
}

bool Alike(const ComparableShape& a, const ComparableShape& b) {
  if (a.fullness_ <= 0 || b.fullness_ <= 0) return false;
  // A first look that costs nothing.
  constexpr double kOtherFullness = 1.5;
  const double ratio = a.fullness_ / b.fullness_;
  if (ratio > kOtherFullness || ratio < 1.0 / kOtherFullness) return false;
  for (int turns = 0; turns < 4; ++turns) {
    if (!ComparableShape::LiesNear(b, turns, a) ||
        !ComparableShape::LiesNear(a, (4 - turns) % 4, b)) {
      continue;
    }
    Eigen::Vector3d extent_turned = b.extent_;
    if (turns % 2 != 0) std::swap(extent_turned.x(), extent_turned.y());
    const VoxelGrid fitted = shape::StretchGrid(shape::TurnGrid(*b.grid_, turns),
                                                a.extent_.cwiseQuotient(extent_turned));
    if (shape::GridIntersectionOverUnion(*a.grid_, fitted) > kAlikeIou) return true;
    if (ShareNear(fitted, a.squared_distance_) > kNearlyAllNear &&
        ShareNear(*a.grid_, shape::SquaredDistanceTo(fitted, true)) > kNearlyAllNear) {
      return true;
    }
  }
  return false;
}

bool ShapesAlike(const VoxelGrid& a, const VoxelGrid& b) {
  return Alike(ComparableShape(a), ComparableShape(b));
}

}  // namespace deepslam::library
