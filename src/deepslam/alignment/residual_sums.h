// Sums over the residuals of an alignment that a Gauss-Newton step is made of: normal equations,
// and a robust spread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "deepslam/alignment/batch_columns.h"
#include "deepslam/alignment/plane_match.h"
#include "deepslam/alignment/projected_points.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

inline constexpr float kMadToSigma = 1.4826F;  // of normally distributed residuals

// Median of absolute residuals, by a histogram.
class MedianHistogram {
 public:
  static constexpr int kNumBins = 512;  // larger residuals fall into the last

  // Where a residual falls; one bin past the last for what does not count (0).
  static std::int32_t Bin(float absolute, float bins_per_unit, float counts) {
    const float last = static_cast<float>(kNumBins - 1);
    const float bin = absolute * bins_per_unit;
    const std::int32_t index = static_cast<std::int32_t>(bin < last ? bin : last);
    return counts > 0 ? index : kNumBins;
  }

  void Add(const IndexColumn& bins, std::size_t size) {
    for (std::size_t k = 0; k < size; ++k) ++bins_[static_cast<std::size_t>(bins[k])];
  }

  // The middle of its bin; the histogram's end where nothing was added.
  [[nodiscard]] float Median(float bins_per_unit) const {
    std::uint32_t count = 0;
    for (std::size_t k = 0; k < kNumBins; ++k) count += bins_[k];
    std::uint32_t below = 0;
    for (std::size_t k = 0; k < kNumBins; ++k) {
      below += bins_[k];
      if (2 * below >= count) return (static_cast<float>(k) + 0.5F) / bins_per_unit;
    }
    return static_cast<float>(kNumBins) / bins_per_unit;
  }

 private:
  std::array<std::uint32_t, kNumBins + 1> bins_{};
};

// Rows of the Jacobian and the residual, of a batch.
struct JacobianRows {
  std::array<Column, 7> column;

  // d is d residual / d p; a left perturbation moves p, in frame i, by t + r x p.
  void Set(std::size_t k, const Triple& d, const Triple& p, float residual) {
    column[0][k] = d.x;
    column[1][k] = d.y;
    column[2][k] = d.z;
    column[3][k] = p.y * d.z - p.z * d.y;
    column[4][k] = p.z * d.x - p.x * d.z;
    column[5][k] = p.x * d.y - p.y * d.x;
    column[6][k] = residual;
  }
};

// Room that the terms share, so that it stays in the cache.
struct JacobianRoom {
  JacobianRows rows;
  JacobianRows source_rows;  // of what frame j sees
};

// J^T W J and J^T W r.
class NormalSums {
 public:
  void Add(const JacobianRows& rows, const Column& weight, std::size_t size) {
    AddFrom<0>(rows, weight, size, sums_.data());
  }

  void Finish(Matrix6d& hessian, Vector6d& gradient) const {
    std::size_t pair = 0;
    for (int a = 0; a < 6; ++a) {
      for (int b = a; b < 6; ++b) hessian(a, b) = hessian(b, a) = sums_[pair++];
      gradient[a] = sums_[pair++];
    }
  }

 private:
  // Upper triangle of a 6 x 6 matrix and a gradient of 6.
  static constexpr std::size_t kNumPairs = 27;

  template <std::size_t kFirst>
  static void AddFrom(const JacobianRows& rows,
                      const Column& weight,
                      std::size_t size,
                      double* sums) {
    const Column* const first = &rows.column[kFirst];
    constexpr std::size_t kCount = 7 - kFirst;  // products with itself and those behind it
    AddDots<kCount>(weight, *first, first, size, sums);
    if constexpr (kFirst < 5) AddFrom<kFirst + 1>(rows, weight, size, sums + kCount);
  }

  std::array<double, kNumPairs> sums_{};
};

// What the two frames see at a point p_i, in the axes of frame i: normals or intensity gradients.
struct CrossPair {
  Triple point, reference, source;
};

// (A^T W B + B^T W A) / 2, of the Jacobians of what either frame sees.
class CrossSums {
 public:
  // `pair_of` gives the CrossPair of a residual.
  template <typename PairOf>
  void Add(const PairOf& pair_of, const Column& weight, std::size_t size, JacobianRoom& room) {
#pragma GCC ivdep
    for (std::size_t k = 0; k < size; ++k) {
      const CrossPair pair = pair_of(k);
      room.rows.Set(k, pair.reference, pair.point, 0);
      room.source_rows.Set(k, pair.source, pair.point, 0);
    }
    for (std::size_t a = 0; a < 6; ++a) {
      AddDots<6>(weight, room.rows.column[a], room.source_rows.column.data(), size, &sums_[6 * a]);
    }
  }

  void Finish(Matrix6d& hessian) const {
    const Eigen::Map<const Matrix6d> sums(sums_.data());
    hessian = 0.5 * (sums + sums.transpose());
  }

 private:
  std::array<double, 36> sums_{};
};

// Points, by their place in the batch last projected, to a batch of pairs, which `flush` empties
// whenever it is full.
template <typename Pairs, typename Flush>
void AddPairs(const ProjectedPoints& projected,
              std::span<const std::int32_t> points,
              Pairs& pairs,
              const Flush& flush) {
  while (!points.empty()) {
    const std::size_t fitting = std::min(points.size(), kBatch - pairs.size);
    pairs.Add(projected, points.first(fitting));
    points = points.subspan(fitting);
    if (pairs.size == kBatch) flush();
  }
}

}  // namespace deepslam::alignment
