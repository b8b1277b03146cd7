// A symmetric 6 x 6 matrix in the memory of its upper triangle: a long path has hundreds of
// thousands of measurements, and the information of each is most of it.
#pragma once

#include <array>
#include <cstddef>

#include "deepslam/geometry/pose.h"

namespace deepslam {

class SymmetricMatrix6d {
 public:
  SymmetricMatrix6d() : SymmetricMatrix6d(Matrix6d::Zero()) {}
  // Of what is below the diagonal nothing is looked at.
  template <typename Derived>
  SymmetricMatrix6d(  // NOLINT(google-explicit-constructor)
      const Eigen::EigenBase<Derived>& matrix) {
    const Matrix6d full(matrix.derived());
    std::size_t at = 0;
    for (int row = 0; row < 6; ++row) {
      for (int col = row; col < 6; ++col) upper_[at++] = full(row, col);
    }
  }

  [[nodiscard]] Matrix6d Full() const {
    Matrix6d full;
    std::size_t at = 0;
    for (int row = 0; row < 6; ++row) {
      for (int col = row; col < 6; ++col) full(row, col) = full(col, row) = upper_[at++];
    }
    return full;
  }
  friend bool operator==(const SymmetricMatrix6d&, const SymmetricMatrix6d&) = default;

  // Row by row.
  using Upper = std::array<double, 21>;
  explicit SymmetricMatrix6d(const Upper& upper) : upper_(upper) {}
  [[nodiscard]] const Upper& upper() const { return upper_; }

 private:
  Upper upper_;
};

}  // namespace deepslam
