// The shift between two small images of one camera that correlates best.
//
// In the header, so that its only user compiles it for wide vectors (core/wide_vectors.h).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "deepslam/alignment/image_pyramid.h"

namespace deepslam::alignment {

// Of the image's width and height: about 30 degrees of pan for a Kinect.
inline constexpr double kMaxShiftShare = 0.5;

// In pixels: what is at (u, v) in image j is at (u + shift.u, v + shift.v) in image i.
struct ImageShift {
  int u = 0;
  int v = 0;
  double correlation = -1;
};

// Intensities centred on mid-grey, so that single precision does for the sums, and the sums over
// every upper left rectangle of them and of their squares.
class CentredImage {
 public:
  explicit CentredImage(const PyramidLevel& level)
      : width_(level.camera.width),
        height_(level.camera.height),
        values_(level.intensity.size()),
        sums_(static_cast<std::size_t>(width_ + 1) * static_cast<std::size_t>(height_ + 1)),
        squares_(sums_.size()) {
    for (int v = 0; v < height_; ++v) {
      double sum = 0, square = 0;
      for (int u = 0; u < width_; ++u) {
        const std::size_t at = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                               static_cast<std::size_t>(u);
        values_[at] = level.intensity(u, v) - 128.0F;
        const double value = static_cast<double>(values_[at]);
        sum += value;
        square += value * value;
        sums_[Corner(u + 1, v + 1)] = sums_[Corner(u + 1, v)] + sum;
        squares_[Corner(u + 1, v + 1)] = squares_[Corner(u + 1, v)] + square;
      }
    }
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] const float* row(int v) const {
    return values_.data() + static_cast<std::ptrdiff_t>(v) * width_;
  }
  // Over columns [u0, u0 + width) and rows [v0, v0 + height).
  [[nodiscard]] double Sum(int u0, int v0, int width, int height) const {
    return Over(sums_, u0, v0, width, height);
  }
  [[nodiscard]] double SumOfSquares(int u0, int v0, int width, int height) const {
    return Over(squares_, u0, v0, width, height);
  }

 private:
  [[nodiscard]] std::size_t Corner(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_ + 1) +
           static_cast<std::size_t>(u);
  }
  [[nodiscard]] double Over(
      const std::vector<double>& sums, int u0, int v0, int width, int height) const {
    return sums[Corner(u0 + width, v0 + height)] - sums[Corner(u0, v0 + height)] -
           sums[Corner(u0 + width, v0)] + sums[Corner(u0, v0)];
  }

  int width_;
  int height_;
  std::vector<float> values_;
  std::vector<double> sums_;
  std::vector<double> squares_;
};

// In eight partial sums: one order whatever the vector width.
inline float DotOfRows(const float* a, const float* b, int size) {
  constexpr int kLanes = 8;  // floats of 256 bits
  std::array<float, kLanes> lanes{};
  int k = 0;
  for (; k + kLanes <= size; k += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane)
      lanes[static_cast<std::size_t>(lane)] += a[k + lane] * b[k + lane];
  }
  float sum = 0;
  for (; k < size; ++k) sum += a[k] * b[k];
  for (const float lane : lanes) sum += lane;
  return sum;
}

// Normalised cross-correlation of I_j(u, v) with I_i(u + shift).
inline double Correlation(const CentredImage& i, const CentredImage& j, int shift_u, int shift_v) {
  const int u0 = std::max(0, -shift_u), v0 = std::max(0, -shift_v);
  const int width = i.width() - std::abs(shift_u), height = i.height() - std::abs(shift_v);
  if (width < 1 || height < 1) return -1;
  double product = 0;
  for (int v = v0; v < v0 + height; ++v) {
    product +=
        static_cast<double>(DotOfRows(j.row(v) + u0, i.row(v + shift_v) + u0 + shift_u, width));
  }
  const double count = static_cast<double>(width) * height;
  const double mean_j = j.Sum(u0, v0, width, height) / count;
  const double mean_i = i.Sum(u0 + shift_u, v0 + shift_v, width, height) / count;
  const double var_j = j.SumOfSquares(u0, v0, width, height) / count - mean_j * mean_j;
  const double var_i =
      i.SumOfSquares(u0 + shift_u, v0 + shift_v, width, height) / count - mean_i * mean_i;
  // Below one grey level of spread there is nothing to correlate.
  if (!(var_i > 1 && var_j > 1)) return -1;
  return (product / count - mean_i * mean_j) / std::sqrt(var_i * var_j);
}

// Small overlaps correlate by chance: this shrinks them.
inline double OverlapFactor(const PinholeCamera& camera, int u, int v) {
  const double overlap = (1 - std::abs(u) / static_cast<double>(camera.width)) *
                         (1 - std::abs(v) / static_cast<double>(camera.height));
  return std::sqrt(overlap);
}

// Of two images of one camera: exhaustive, up to kMaxShiftShare.
inline ImageShift BestShift(const PyramidLevel& i, const PyramidLevel& j) {
  // No correlation is above 1, but for rounding.
  constexpr double kMostCorrelation = 1.0001;
  const int max_u = static_cast<int>(kMaxShiftShare * i.camera.width);
  const int max_v = static_cast<int>(kMaxShiftShare * i.camera.height);
  const CentredImage centred_i(i), centred_j(j);
  const auto correlation = [&](int u, int v) {
    return Correlation(centred_i, centred_j, u, v) * OverlapFactor(i.camera, u, v);
  };
  // Images that follow each other leave few shifts that could be better than none.
  const double of_none = correlation(0, 0);
  ImageShift best;
  for (int v = -max_v; v <= max_v; ++v) {
    for (int u = -max_u; u <= max_u; ++u) {
      const double most = kMostCorrelation * OverlapFactor(i.camera, u, v);
      if (most < std::max(of_none, best.correlation)) continue;
      const double found = correlation(u, v);
      if (found > best.correlation) best = {u, v, found};
    }
  }
  return best;
}

}  // namespace deepslam::alignment
