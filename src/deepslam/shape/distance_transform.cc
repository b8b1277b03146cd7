#include "deepslam/shape/distance_transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "deepslam/core/wide_vectors.h"

namespace deepslam::shape {
namespace {

constexpr int kSize = kGridSize;
constexpr float kFarSquared = 1e10F;  // squared voxels, where the grid has none to measure to
// Beyond any squared distance in the grid, 3 * 63^2; with the square of a step added it still fits.
constexpr std::int16_t kNothing = 16383;

// Voxels along k: exact, and 16 bits wide, so that the compiler takes eight at a time.
using Row = std::array<std::int16_t, kSize>;
// Rows along one axis of the grid.
using Slab = std::array<Row, kSize>;

// Steps to the nearest place along a row, with room for a look beyond either end.
struct StepsRow {
  static constexpr std::size_t kRoom = kSize / 2;  // the longest step: 1, 2, ..., 32 add up to 63
  static constexpr std::uint8_t kFarSteps = 127;  // more than a row has; twice that still fits
  std::array<std::uint8_t, kSize + 2 * kRoom> steps;

  std::uint8_t* begin() { return steps.data() + kRoom; }
};

// Squared distances along k to those voxels that are places (1), some of them.
void TransformMixedRow(const std::array<std::uint8_t, kSize>& is_place, Row& row) {
  StepsRow one;
  StepsRow other;
  one.steps.fill(StepsRow::kFarSteps);
  other.steps.fill(StepsRow::kFarSteps);
  std::uint8_t* from = one.begin();
  std::uint8_t* to = other.begin();
  for (std::size_t n = 0; n < kSize; ++n) from[n] = is_place[n] != 0 ? 0 : StepsRow::kFarSteps;
  // Every distance is a sum of powers of two.
  for (std::size_t step = 1; step <= StepsRow::kRoom; step *= 2) {
    const std::uint8_t* const below = from - step;
    const std::uint8_t* const above = from + step;
#pragma GCC ivdep
    for (std::size_t n = 0; n < kSize; ++n) {
      const auto beside = static_cast<std::uint8_t>(std::min(below[n], above[n]) + step);
      to[n] = std::min(from[n], beside);
    }
    std::swap(from, to);
  }
  for (std::size_t n = 0; n < kSize; ++n) row[n] = static_cast<std::int16_t>(from[n] * from[n]);
}

// Squared distances along k to voxels of that occupancy.
void TransformRow(const std::uint8_t* voxels, bool occupied, Row& row) {
  std::array<std::uint8_t, kSize> is_place;
  std::uint8_t all = 1;
  std::uint8_t any = 0;
  for (std::size_t n = 0; n < kSize; ++n) {
    is_place[n] = (voxels[n] != 0) == occupied ? 1 : 0;
    all &= is_place[n];
    any |= is_place[n];
  }
  if (all == any) {
    row.fill(any != 0 ? std::int16_t{0} : kNothing);
  } else {
    TransformMixedRow(is_place, row);
  }
}

void TakeNearer(const Row& other, std::int16_t squared_step, Row& row) {
  for (std::size_t n = 0; n < kSize; ++n) {
    row[n] = std::min(row[n], static_cast<std::int16_t>(other[n] + squared_step));
  }
}

std::int16_t Largest(const Row& row) {
  std::int16_t largest = 0;
  for (std::size_t n = 0; n < kSize; ++n) largest = std::max(largest, row[n]);
  return largest;
}

// Along its rows nothing is near or something is.
bool IsNearNothing(const Row& row) { return row.front() == kNothing; }

// Squared distances across the rows: steps outwards until none can be nearer any more.
void TransformAcross(const Slab& slab, Slab& result) {
  constexpr int kUnchecked = 4;  // steps between looks at what is largest
  const auto first = std::find_if_not(slab.begin(), slab.end(), IsNearNothing);
  result = slab;
  if (first == slab.end()) return;
  const auto last = std::find_if_not(slab.rbegin(), slab.rend(), IsNearNothing);
  const auto low = static_cast<int>(first - slab.begin());
  const auto high = static_cast<int>(slab.rend() - last) - 1;
  for (int x = 0; x < kSize; ++x) {
    Row& row = result[static_cast<std::size_t>(x)];
    const int farthest = std::max(x - low, high - x);
    for (int step = std::max({1, low - x, x - high}), n = 0; step <= farthest; ++step, ++n) {
      const auto squared = static_cast<std::int16_t>(step * step);
      if (n % kUnchecked == 0 && squared >= Largest(row)) break;
      if (x - step >= low) TakeNearer(slab[static_cast<std::size_t>(x - step)], squared, row);
      if (x + step <= high) TakeNearer(slab[static_cast<std::size_t>(x + step)], squared, row);
    }
  }
}

// Rows of the grid, one after another along j, kSize apart along i: squared distances to voxels of
// that occupancy.
std::vector<Row> TransformGrid(const VoxelGrid& grid, bool occupied) {
  std::vector<Row> rows(static_cast<std::size_t>(kSize) * kSize);
  for (std::size_t r = 0; r < rows.size(); ++r)
    TransformRow(grid.occupied.data() + r * kSize, occupied, rows[r]);
  Slab slab;
  Slab transformed;
  for (const std::size_t stride : {std::size_t{1}, std::size_t{kSize}}) {
    const std::size_t other_stride = stride == 1 ? kSize : 1;
    for (std::size_t a = 0; a < kSize; ++a) {
      for (std::size_t n = 0; n < kSize; ++n) slab[n] = rows[a * other_stride + n * stride];
      TransformAcross(slab, transformed);
      for (std::size_t n = 0; n < kSize; ++n) rows[a * other_stride + n * stride] = transformed[n];
    }
  }
  return rows;
}

float SquaredVoxels(std::int16_t value) {
  return value == kNothing ? kFarSquared : static_cast<float>(value);
}

}  // namespace

DEEPSLAM_WIDE_VECTORS std::vector<float> SquaredDistanceTo(const VoxelGrid& grid, bool occupied) {
  const std::vector<Row> rows = TransformGrid(grid, occupied);
  std::vector<float> squared(grid.occupied.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t n = 0; n < kSize; ++n) squared[r * kSize + n] = SquaredVoxels(rows[r][n]);
  }
  return squared;
}

DEEPSLAM_WIDE_VECTORS std::vector<float> SignedDistance(const VoxelGrid& grid) {
  const std::vector<Row> to_occupied = TransformGrid(grid, true);
  const std::vector<Row> to_free = TransformGrid(grid, false);
  std::vector<float> distances(grid.occupied.size());
  for (std::size_t r = 0; r < to_free.size(); ++r) {
    const std::uint8_t* const occupied = grid.occupied.data() + r * kSize;
    float* const distance = distances.data() + r * kSize;
    Row inwards;  // those inside are negative
    for (std::size_t n = 0; n < kSize; ++n) {
      const auto inside = static_cast<std::int16_t>(-to_free[r][n]);
      inwards[n] = occupied[n] != 0 ? inside : to_occupied[r][n];
    }
    for (std::size_t n = 0; n < kSize; ++n) {
      const std::int32_t signed_square = inwards[n];
      const std::int32_t square = signed_square < 0 ? -signed_square : signed_square;
      const float squared = square == kNothing ? kFarSquared : static_cast<float>(square);
      // The boundary lies half a voxel from the centres on its both sides.
      const float voxels = std::sqrt(squared) - 0.5F;
      distance[n] = signed_square < 0 ? -voxels : voxels;
    }
  }
  return distances;
}

}  // namespace deepslam::shape
