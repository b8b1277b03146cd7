// The pixels of one thing in an image, kept small: a capture has tens of thousands of them. Packed
// bits of the window that holds them; as large an image as it is, a mask costs what the thing
// covers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "deepslam/core/image.h"

namespace deepslam {

class PixelMask {
 public:
  PixelMask() = default;
  PixelMask(const Mask& mask);  // NOLINT(google-explicit-constructor): the same in another form

  // Of the image.
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool empty() const { return width_ == 0 || height_ == 0; }
  // 1 where the pixel belongs to it; (u, v) in the image.
  std::uint8_t operator()(int u, int v) const {
    const int i = u - u0_;
    const int j = v - v0_;
    if (i < 0 || j < 0 || i >= window_width_ || j >= window_height_) return 0;
    const std::size_t at = static_cast<std::size_t>(j) * static_cast<std::size_t>(window_width_) +
                           static_cast<std::size_t>(i);
    return static_cast<std::uint8_t>(bits_[at / 64] >> (at % 64) & 1);
  }
  [[nodiscard]] Mask Unpacked() const;

  friend bool operator==(const PixelMask&, const PixelMask&) = default;

 private:
  int width_ = 0;
  int height_ = 0;
  // The smallest window that holds all its pixels; no size where there are none.
  int u0_ = 0;
  int v0_ = 0;
  int window_width_ = 0;
  int window_height_ = 0;
  std::vector<std::uint64_t> bits_;  // of the window, row by row
};

}  // namespace deepslam
