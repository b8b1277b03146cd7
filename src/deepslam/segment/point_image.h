// The points of a frame, one plane per coordinate, so that loops over pixels use wide vectors.
#pragma once

#include <Eigen/Core>

#include "deepslam/core/image.h"

namespace deepslam::segment {

// Pixels without a usable point have z = 0. Around the image lies a margin of such pixels.
class PointImage {
 public:
  static constexpr int kMarginRows = 12;     // of the widest baseline in smooth_links.cc
  static constexpr int kMarginColumns = 16;  // pixels that smooth_links.cc takes side by side

  PointImage() = default;
  PointImage(int width, int height)
      : x_m_(width + 2 * kMarginColumns, height + 2 * kMarginRows),
        y_m_(x_m_.width(), x_m_.height()),
        z_m_(x_m_.width(), x_m_.height()),
        width_(width),
        height_(height) {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  // Pixel 0 of row v, in the margin too, with kMarginColumns before it and behind its last.
  [[nodiscard]] const float* x_row(int v) const { return Row(x_m_, v); }
  [[nodiscard]] const float* y_row(int v) const { return Row(y_m_, v); }
  [[nodiscard]] const float* z_row(int v) const { return Row(z_m_, v); }
  [[nodiscard]] float* x_row(int v) { return x_m_.row(v + kMarginRows) + kMarginColumns; }
  [[nodiscard]] float* y_row(int v) { return y_m_.row(v + kMarginRows) + kMarginColumns; }
  [[nodiscard]] float* z_row(int v) { return z_m_.row(v + kMarginRows) + kMarginColumns; }

  [[nodiscard]] float z_m(int u, int v) const { return z_row(v)[u]; }
  [[nodiscard]] Eigen::Vector3f operator()(int u, int v) const {
    return {x_row(v)[u], y_row(v)[u], z_row(v)[u]};
  }
  void Clear(int u, int v) { x_row(v)[u] = y_row(v)[u] = z_row(v)[u] = 0.0F; }

 private:
  static const float* Row(const Image<float>& plane, int v) {
    return plane.row(v + kMarginRows) + kMarginColumns;
  }

  Image<float> x_m_;
  Image<float> y_m_;
  Image<float> z_m_;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace deepslam::segment
