// Normal equations of seven unknowns, as similarities and stretched placements have.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "deepslam/geometry/point_columns.h"

namespace deepslam {

// Sums over residuals r with derivatives J of weight * J J^T and weight * J r. Summed column by
// column with the residual as an eighth row, so that a row of the Jacobian is whole vectors.
class SevenEquations {
 public:
  using Vector = Eigen::Matrix<double, 7, 1>;
  using Matrix = Eigen::Matrix<double, 7, 7>;

  // Within the caller's loop, which is compiled for wide vectors: a call for each would not be.
  [[gnu::always_inline]] inline void Add(const std::array<double, 7>& jacobian,
                                         double residual,
                                         double weight) {
    std::array<double, kRows> row;
    for (std::size_t k = 0; k < kColumns; ++k) row[k] = jacobian[k];
    row[kColumns] = residual;
    for (std::size_t column = 0; column < kColumns; ++column) {
      const double weighted = weight * row[column];
      for (std::size_t k = 0; k < kRows; ++k) sums_[column * kRows + k] += weighted * row[k];
    }
  }

  // Of a batch: derivatives by each unknown, then the residuals.
  using Columns = std::array<PointColumn, 8>;
  // Those up to `size`, a multiple of kPointLanes.
  void Add(const Columns& columns, const PointColumn& weight, std::size_t size) {
    AddFrom<0>(columns, weight, size);
  }

  [[nodiscard]] Matrix Hessian() const { return Sums().topRows<7>(); }
  [[nodiscard]] Vector Gradient() const { return Sums().row(7); }

 private:
  static constexpr std::size_t kColumns = 7;
  static constexpr std::size_t kRows = 8;

  // Row of the Hessian and entry of the gradient from the diagonal on: all at once, so that none
  // waits for its own last addition.
  template <std::size_t kFirst>
  void AddFrom(const Columns& columns, const PointColumn& weight, std::size_t size) {
    using Lanes [[gnu::vector_size(kPointLanes * sizeof(float)), gnu::may_alias]] = float;
    const auto at = [](const PointColumn& column, std::size_t k) -> const Lanes& {
      return reinterpret_cast<const Lanes&>(column[k]);
    };
    constexpr std::size_t kCount = kRows - kFirst;
    Lanes lanes[kCount] = {};
    for (std::size_t k = 0; k < size; k += kPointLanes) {
      const Lanes weighted = at(weight, k) * at(columns[kFirst], k);
      for (std::size_t n = 0; n < kCount; ++n) lanes[n] += weighted * at(columns[kFirst + n], k);
    }
    for (std::size_t n = 0; n < kCount; ++n) {
      double sum = 0;
      for (std::size_t lane = 0; lane < kPointLanes; ++lane)
        sum += static_cast<double>(lanes[n][lane]);
      const std::size_t row = kFirst + n;
      sums_[kFirst * kRows + row] += sum;
      if (n > 0 && row < kColumns) sums_[row * kRows + kFirst] += sum;
    }
    if constexpr (kFirst + 1 < kColumns) AddFrom<kFirst + 1>(columns, weight, size);
  }

  [[nodiscard]] Eigen::Map<const Eigen::Matrix<double, 8, 7>> Sums() const {
    return Eigen::Map<const Eigen::Matrix<double, 8, 7>>(sums_.data());
  }

  alignas(32) std::array<double, kRows * kColumns> sums_{};
};

}  // namespace deepslam
