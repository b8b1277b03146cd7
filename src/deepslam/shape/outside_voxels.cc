#include "deepslam/shape/outside_voxels.h"

#include <utility>

namespace deepslam::shape {
namespace {

constexpr std::size_t kRowsPerSlice = kGridSize;   // of one i
constexpr std::uint64_t kAll = ~std::uint64_t{0};  // a row's voxels, a bit each
// First and last of a row: at the rim.
constexpr std::uint64_t kEnds = (std::uint64_t{1} << (kGridSize - 1)) | 1U;

// All of `free` that `from` reaches along the row (Kogge, Stone 1973: in steps of 1, 2, 4, ...).
std::uint64_t ReachAlong(std::uint64_t from, std::uint64_t free) {
  std::uint64_t up = from & free;
  std::uint64_t down = up;
  std::uint64_t open_up = free;
  std::uint64_t open_down = free;
  for (int step = 1; step < kGridSize; step *= 2) {
    up |= open_up & (up << step);
    open_up &= open_up << step;
    down |= open_down & (down >> step);
    open_down &= open_down >> step;
  }
  return up | down;
}

bool IsAtRim(std::size_t row) {
  const std::size_t i = row / kRowsPerSlice;
  const std::size_t j = row % kRowsPerSlice;
  return i == 0 || i == kRowsPerSlice - 1 || j == 0 || j == kRowsPerSlice - 1;
}

class Flood {
 public:
  explicit Flood(const VoxelRows& free) : free_(free), reached_(kNumVoxelRows, 0) {}

  VoxelRows Run() {
    for (std::size_t row = 0; row < kNumVoxelRows; ++row) Enter(row, IsAtRim(row) ? kAll : kEnds);
    while (!open_.empty()) {
      const std::size_t row = open_.back();
      open_.pop_back();
      Spread(row);
    }
    return std::move(reached_);
  }

 private:
  void Enter(std::size_t row, std::uint64_t from) {
    if ((from & free_[row] & ~reached_[row]) == 0) return;
    reached_[row] |= ReachAlong(from, free_[row]);
    open_.push_back(row);
  }
  void Spread(std::size_t row) {
    const std::uint64_t reached = reached_[row];
    if (row >= kRowsPerSlice) Enter(row - kRowsPerSlice, reached);
    if (row + kRowsPerSlice < kNumVoxelRows) Enter(row + kRowsPerSlice, reached);
    if (row % kRowsPerSlice != 0) Enter(row - 1, reached);
    if (row % kRowsPerSlice != kRowsPerSlice - 1) Enter(row + 1, reached);
  }

  const VoxelRows& free_;
  VoxelRows reached_;
  std::vector<std::size_t> open_;
};

}  // namespace

VoxelRows OutsideVoxels(const VoxelRows& free) { return Flood(free).Run(); }

}  // namespace deepslam::shape
