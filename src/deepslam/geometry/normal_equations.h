// Normal equations of seven unknowns, as similarities and stretched placements have.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "deepslam/geometry/lanes.h"
#include "deepslam/geometry/point_columns.h"

namespace deepslam {

// Sums over residuals r with derivatives J of weight * J J^T and weight * J r. Summed column by
// column with the residual as an eighth row, so that a row of the Jacobian is whole vectors.
class SevenEquations {
 public:
  using Vector = Eigen::Matrix<double, 7, 1>;
  using Matrix = Eigen::Matrix<double, 7, 7>;

  void Add(const std::array<double, 7>& jacobian, double residual, double weight) {
    std::array<double, kRows> row;
    for (std::size_t k = 0; k < kColumns; ++k) row[k] = jacobian[k];
    row[kColumns] = residual;
    for (std::size_t column = 0; column < kColumns; ++column) {
      const double weighted = weight * row[column];
      for (std::size_t k = 0; k < kRows; ++k) sums_[column * kRows + k] += weighted * row[k];
    }
  }

  // A residual's derivatives by each unknown, then the residual itself.
  struct alignas(32) Row : std::array<double, 8> {};
  // Those up to `size`, one after another. Here, for its callers' loops, which are compiled for
  // wide vectors; spelt out as vectors because the compiler takes sums of arrays one by one.
  void Add(const Row* rows, const double* weights, std::size_t size) {
    AddColumns<0, 0>(rows, weights, size);
    AddColumns<4, 1>(rows, weights, size);
    for (std::size_t column = 4; column < kColumns; ++column) {
      for (std::size_t row = 0; row < 4; ++row)
        sums_[column * kRows + row] = sums_[row * kRows + column];
    }
  }

  // Of a batch: derivatives by each unknown, then the residuals.
  using Columns = std::array<PointColumn, 8>;
  // Those up to `size`, a multiple of kPointLanes.
  static_assert(kPointLanes == kLanes);
  void Add(const Columns& columns, const PointColumn& weight, std::size_t size) {
    AddFrom<0>(columns, weight, size);
  }

  [[nodiscard]] Matrix Hessian() const { return Sums().topRows<7>(); }
  [[nodiscard]] Vector Gradient() const { return Sums().row(7); }

 private:
  static constexpr std::size_t kColumns = 7;  // unknowns
  static constexpr std::size_t kRows = 8;     // the unknowns, and the residual

  using Quad [[gnu::vector_size(4 * sizeof(double)), gnu::may_alias]] = double;

  // Columns kFirst to kFirst + 3, as far as there are, from the kQuad-th quad of rows on.
  template <std::size_t kFirst, std::size_t kQuad>
  void AddColumns(const Row* rows, const double* weights, std::size_t size) {
    // Columns of this quad that there are.
    constexpr std::size_t kCount = kFirst + 4 < kColumns ? 4 : kColumns - kFirst;
    constexpr std::size_t kQuads = kRows / 4 - kQuad;  // quads of rows from kQuad on
    Quad sums[kCount][kQuads];
    const auto total = [&](std::size_t column, std::size_t quad) -> Quad& {
      return reinterpret_cast<Quad&>(sums_[(kFirst + column) * kRows + 4 * (kQuad + quad)]);
    };
    for (std::size_t column = 0; column < kCount; ++column) {
      for (std::size_t quad = 0; quad < kQuads; ++quad) sums[column][quad] = total(column, quad);
    }
    for (std::size_t n = 0; n < size; ++n) {
      const double* const row = rows[n].data();
      for (std::size_t column = 0; column < kCount; ++column) {
        const double weighted = weights[n] * row[kFirst + column];
        for (std::size_t quad = 0; quad < kQuads; ++quad) {
          sums[column][quad] += weighted * reinterpret_cast<const Quad&>(row[4 * (kQuad + quad)]);
        }
      }
    }
    for (std::size_t column = 0; column < kCount; ++column) {
      for (std::size_t quad = 0; quad < kQuads; ++quad) total(column, quad) = sums[column][quad];
    }
  }

  // Row of the Hessian and entry of the gradient from the diagonal on.
  template <std::size_t kFirst>
  void AddFrom(const Columns& columns, const PointColumn& weight, std::size_t size) {
    constexpr std::size_t kCount = kRows - kFirst;
    std::array<double, kCount> sums{};
    AddDots<kCount>(weight, columns[kFirst], &columns[kFirst], size, sums.data());
    for (std::size_t n = 0; n < kCount; ++n) {
      const std::size_t row = kFirst + n;
      sums_[kFirst * kRows + row] += sums[n];
      if (n > 0 && row < kColumns) sums_[row * kRows + kFirst] += sums[n];
    }
    if constexpr (kFirst + 1 < kColumns) AddFrom<kFirst + 1>(columns, weight, size);
  }

  [[nodiscard]] Eigen::Map<const Eigen::Matrix<double, 8, 7>> Sums() const {
    return Eigen::Map<const Eigen::Matrix<double, 8, 7>>(sums_.data());
  }

  alignas(32) std::array<double, kRows * kColumns> sums_{};
};

}  // namespace deepslam
