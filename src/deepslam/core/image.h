// A dense image, row-major, no padding. Pixel (u, v): u column, v row; (0, 0) is the centre of the
// top-left pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "deepslam/core/check.h"

namespace deepslam {

struct Rgb8 {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T fill = T())
      : width_(width), height_(height), pixels_(CheckedSize(width, height), fill) {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool empty() const { return pixels_.empty(); }
  [[nodiscard]] std::size_t size() const { return pixels_.size(); }
  [[nodiscard]] bool Contains(int u, int v) const {
    return u >= 0 && v >= 0 && u < width_ && v < height_;
  }

  T& operator()(int u, int v) { return pixels_[Offset(u, v)]; }
  const T& operator()(int u, int v) const { return pixels_[Offset(u, v)]; }

  T* row(int v) { return pixels_.data() + Offset(0, v); }
  const T* row(int v) const { return pixels_.data() + Offset(0, v); }
  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }
  auto begin() { return pixels_.begin(); }
  auto end() { return pixels_.end(); }
  auto begin() const { return pixels_.begin(); }
  auto end() const { return pixels_.end(); }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  static std::size_t CheckedSize(int width, int height) {
    DEEPSLAM_CHECK(width >= 0 && height >= 0, "negative image size");
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  [[nodiscard]] std::size_t Offset(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(u);
  }

  int width_ = 0;
  int height_ = 0;
  std::vector<T> pixels_;
};

// std::vector<bool> has no addressable elements: masks are bytes, 0 or 1.
using Mask = Image<std::uint8_t>;
// Depth along the optical axis in metres; 0 is invalid. Never NaN or negative.
using DepthImage = Image<float>;
using ColourImage = Image<Rgb8>;
using IntensityImage = Image<float>;  // grey levels, 0 to 255

}  // namespace deepslam
