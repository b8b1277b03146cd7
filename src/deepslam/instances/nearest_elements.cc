#include "deepslam/instances/nearest_elements.h"

#include <cmath>

namespace deepslam::instances {
namespace {

// Depth within noise of the surface lies no farther from an element.
constexpr float kReachVoxels = 1.5F;

int CellInBlock(const Eigen::Vector3i& cell, int bits) {
  const int mask = (1 << bits) - 1;
  return ((cell.x() & mask) << (2 * bits)) | ((cell.y() & mask) << bits) | (cell.z() & mask);
}

Eigen::Vector3i BlockOf(const Eigen::Vector3i& cell, int bits) {
  return {cell.x() >> bits, cell.y() >> bits, cell.z() >> bits};
}

}  // namespace

std::size_t NearestElements::Hash::operator()(const Eigen::Vector3i& block) const {
  // Large primes of Teschner et al. 2003.
  return static_cast<std::size_t>(block.x()) * 73856093U ^
         static_cast<std::size_t>(block.y()) * 19349663U ^
         static_cast<std::size_t>(block.z()) * 83492791U;
}

NearestElements::NearestElements(const SurfaceElements& elements)
    : cell_m_(static_cast<float>(elements.voxel_m() / 2)) {
  for (std::size_t i = 0; i < elements.size(); ++i) Offer(static_cast<int>(i), elements);
}

std::size_t NearestElements::FirstCellOf(const Eigen::Vector3i& block) {
  constexpr std::size_t kNumCells = std::size_t{kBlockSide} * kBlockSide * kBlockSide;
  const auto [place, is_new] = first_cell_of_.try_emplace(block, element_of_cell_.size());
  if (is_new) element_of_cell_.resize(element_of_cell_.size() + kNumCells, -1);
  return place->second;
}

void NearestElements::Offer(int element, const SurfaceElements& elements) {
  const float reach_m = kReachVoxels * 2 * cell_m_;
  const auto& points = elements.points();
  const Eigen::Vector3f& p = points[static_cast<std::size_t>(element)];
  const Eigen::Vector3i low = ((p.array() - reach_m) / cell_m_).floor().cast<int>();
  const Eigen::Vector3i high = ((p.array() + reach_m) / cell_m_).floor().cast<int>();
  Eigen::Vector3i block = Eigen::Vector3i::Constant(kNoBlock);
  std::size_t first = 0;
  for (int x = low.x(); x <= high.x(); ++x) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int z = low.z(); z <= high.z(); ++z) {
        const Eigen::Vector3i cell(x, y, z);
        const Eigen::Vector3f middle = (cell.cast<float>().array() + 0.5F) * cell_m_;
        const float squared_m2 = (middle - p).squaredNorm();
        if (squared_m2 > reach_m * reach_m) continue;
        if (const Eigen::Vector3i own = BlockOf(cell, kBlockBits); own != block) {
          block = own;
          first = FirstCellOf(block);
        }
        std::int32_t& nearest =
            element_of_cell_[first + static_cast<std::size_t>(CellInBlock(cell, kBlockBits))];
        if (nearest < 0 ||
            squared_m2 < (middle - points[static_cast<std::size_t>(nearest)]).squaredNorm())
          nearest = element;
      }
    }
  }
}

int NearestElements::Cursor::At(const Eigen::Vector3f& point) {
  if (!point.allFinite() || point.cwiseAbs().maxCoeff() >= kMaxCoordinateM) return -1;
  const Eigen::Vector3i cell = (point.array() / nearest_.cell_m_).floor().cast<int>();
  if (const Eigen::Vector3i block = BlockOf(cell, kBlockBits); block != block_) {
    block_ = block;
    const auto found = nearest_.first_cell_of_.find(block);
    cells_ = found == nearest_.first_cell_of_.end()
                 ? nullptr
                 : nearest_.element_of_cell_.data() + found->second;
  }
  return cells_ == nullptr ? -1 : cells_[CellInBlock(cell, kBlockBits)];
}

}  // namespace deepslam::instances
