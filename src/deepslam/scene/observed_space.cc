#include "deepslam/scene/observed_space.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "deepslam/core/check.h"

namespace deepslam {
namespace {

// Indices are counted in 32-bit integers; whatever lies beyond was never looked at.
constexpr double kMaxVoxels = 1e9;

}  // namespace

bool ObservedSpace::IsBefore(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

ObservedSpace::ObservedSpace(double voxel_m, std::vector<SpaceBlock> blocks)
    : voxel_m_(voxel_m), blocks_(std::move(blocks)) {
  DEEPSLAM_CHECK(voxel_m_ > 0, "voxels have a size");
  for (std::size_t n = 1; n < blocks_.size(); ++n)
    DEEPSLAM_CHECK(IsBefore(blocks_[n - 1].index, blocks_[n].index), "blocks ascend, each once");
}

ObservedSpace::Place ObservedSpace::PlaceOf(const Eigen::Vector3d& point) const {
  const Eigen::Array3d at = (point / voxel_m_).array().floor();
  if (!(at.abs() < kMaxVoxels).all()) return {};
  const Eigen::Array3i voxel = at.cast<int>();
  // Shifts round towards minus infinity, as blocks need it.
  static_assert(SpaceBlock::kSide == 16);
  const Eigen::Vector3i index(voxel.x() >> 4, voxel.y() >> 4, voxel.z() >> 4);
  const auto found = std::lower_bound(
      blocks_.begin(), blocks_.end(), index, [](const SpaceBlock& block, const Eigen::Vector3i& i) {
        return IsBefore(block.index, i);
      });
  if (found == blocks_.end() || found->index != index) return {};
  const auto inside = [&](int axis) { return static_cast<std::size_t>(voxel[axis] & 15); };
  return {&*found, (inside(0) * SpaceBlock::kSide + inside(1)) * SpaceBlock::kSide + inside(2)};
}

int ObservedSpace::Passed(const Eigen::Vector3d& point) const {
  const Place place = PlaceOf(point);
  return place.block == nullptr ? 0 : place.block->passed[place.voxel];
}

int ObservedSpace::Blind(const Eigen::Vector3d& point) const {
  const Place place = PlaceOf(point);
  return place.block == nullptr ? 0 : place.block->blind[place.voxel];
}

}  // namespace deepslam
