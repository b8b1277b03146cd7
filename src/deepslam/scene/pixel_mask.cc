#include "deepslam/scene/pixel_mask.h"

#include <algorithm>

namespace deepslam {

PixelMask::PixelMask(const Mask& mask) : width_(mask.width()), height_(mask.height()) {
  int u1 = -1;
  int v1 = -1;
  u0_ = width_;
  for (int v = 0; v < height_; ++v) {
    const std::uint8_t* const row = mask.row(v);
    const std::uint8_t* const end = row + width_;
    const auto set = [](std::uint8_t pixel) { return pixel != 0; };
    const std::uint8_t* const first = std::find_if(row, end, set);
    if (first == end) continue;
    const std::uint8_t* last = end;
    while (*(last - 1) == 0) --last;
    if (v1 < 0) v0_ = v;
    v1 = v;
    u0_ = std::min(u0_, static_cast<int>(first - row));
    u1 = std::max(u1, static_cast<int>(last - row) - 1);
  }
  if (v1 < 0) {
    u0_ = 0;
    return;
  }
  window_width_ = u1 - u0_ + 1;
  window_height_ = v1 - v0_ + 1;
  const std::size_t num_pixels =
      static_cast<std::size_t>(window_width_) * static_cast<std::size_t>(window_height_);
  bits_.assign((num_pixels + 63) / 64, 0);
  std::size_t at = 0;
  for (int v = v0_; v <= v1; ++v) {
    for (int u = u0_; u <= u1; ++u, ++at) {
      if (mask(u, v) != 0) bits_[at / 64] |= std::uint64_t{1} << (at % 64);
    }
  }
}

Mask PixelMask::Unpacked() const {
  Mask mask(width_, height_);
  for (int v = v0_; v < v0_ + window_height_; ++v) {
    for (int u = u0_; u < u0_ + window_width_; ++u) mask(u, v) = (*this)(u, v);
  }
  return mask;
}

}  // namespace deepslam
