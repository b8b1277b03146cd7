#include "deepslam/shape/distance_transform.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "deepslam/core/wide_vectors.h"

namespace deepslam::shape {
namespace {

constexpr int kSize = kGridSize;
constexpr float kFar = 1e10F;
// Beyond any squared distance in the grid, 3 * 63^2; with the square of a step added it still fits.
constexpr std::int16_t kNothing = 16383;

// Voxels along k: exact, and 16 bits wide, so that the compiler takes eight at a time.
using Row = std::array<std::int16_t, kSize>;
// Rows along one axis of the grid.
using Slab = std::array<Row, kSize>;

// Squared distances along k from a row of places (0) and others (kNothing).
void TransformRow(Row& row) {
  constexpr std::int16_t kNone =
      127;  // steps, more than the grid has; its square is within kNothing
  const auto sweep = [&row](int begin, int end, int step) {
    std::int16_t steps = kNone;
    for (int n = begin; n != end; n += step) {
      std::int16_t& value = row[static_cast<std::size_t>(n)];
      steps =
          value == 0 ? std::int16_t{0} : static_cast<std::int16_t>(std::min<int>(steps + 1, kNone));
      const auto squared = static_cast<std::int16_t>(steps == kNone ? kNothing : steps * steps);
      value = std::min(value, squared);
    }
  };
  sweep(0, kSize, 1);
  sweep(kSize - 1, -1, -1);
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

// Squared distances across the rows: steps outwards until none can be nearer any more.
void TransformAcross(const Slab& slab, Slab& result) {
  for (int x = 0; x < kSize; ++x) {
    Row& row = result[static_cast<std::size_t>(x)];
    row = slab[static_cast<std::size_t>(x)];
    for (int step = 1; step < kSize; ++step) {
      const auto squared = static_cast<std::int16_t>(step * step);
      if (squared >= Largest(row)) break;
      if (x >= step) TakeNearer(slab[static_cast<std::size_t>(x - step)], squared, row);
      if (x + step < kSize) TakeNearer(slab[static_cast<std::size_t>(x + step)], squared, row);
    }
  }
}

}  // namespace

DEEPSLAM_WIDE_VECTORS std::vector<float> SquaredDistanceTo(const VoxelGrid& grid, bool occupied) {
  std::vector<Row> rows(static_cast<std::size_t>(kSize) * kSize);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t n = 0; n < kSize; ++n) {
      const bool is_place = (grid.occupied[r * kSize + n] != 0) == occupied;
      rows[r][n] = is_place ? std::int16_t{0} : kNothing;
    }
    TransformRow(rows[r]);
  }
  Slab slab;
  Slab transformed;
  // Rows lie one after another along j, kSize apart along i.
  for (const std::size_t stride : {std::size_t{1}, std::size_t{kSize}}) {
    const std::size_t other_stride = stride == 1 ? kSize : 1;
    for (std::size_t a = 0; a < kSize; ++a) {
      for (std::size_t n = 0; n < kSize; ++n) slab[n] = rows[a * other_stride + n * stride];
      TransformAcross(slab, transformed);
      for (std::size_t n = 0; n < kSize; ++n) rows[a * other_stride + n * stride] = transformed[n];
    }
  }
  std::vector<float> squared(grid.occupied.size());
  for (std::size_t n = 0; n < squared.size(); ++n) {
    const std::int16_t value = rows[n / kSize][n % kSize];
    squared[n] = value == kNothing ? kFar : static_cast<float>(value);
  }
  return squared;
}

}  // namespace deepslam::shape
