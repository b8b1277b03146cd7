#include "deepslam/scene/pixel_mask.h"

#include <algorithm>
#include <cstring>

#include "deepslam/scene/set_pixels.h"

namespace deepslam {
namespace {

constexpr std::size_t kAtOnce = 8;  // pixels, one a byte of a word
constexpr std::uint64_t kLowBits = 0x0101010101010101;
constexpr std::uint64_t kAllButHighBits = 0x7f7f7f7f7f7f7f7f;

std::uint64_t WordAt(const std::uint8_t* pixels, std::size_t count = kAtOnce) {
  std::uint64_t word = 0;
  if (count == kAtOnce) {
    std::memcpy(&word, pixels, kAtOnce);
  } else {
    std::memcpy(&word, pixels, count);
  }
  return word;
}

// Of a row with a pixel that is set.
const std::uint8_t* LastSet(const std::uint8_t* begin, const std::uint8_t* end) {
  while (end - begin >= static_cast<std::ptrdiff_t>(kAtOnce) && WordAt(end - kAtOnce) == 0)
    end -= kAtOnce;
  while (*(end - 1) == 0) --end;
  return end - 1;
}

// The lowest eight bits: 1 where a byte of the word is not 0.
std::uint64_t BitsOf(std::uint64_t word) {
  const std::uint64_t set = (((word & kAllButHighBits) + kAllButHighBits) | word) >> 7 & kLowBits;
  // Byte k moves to bit k of the highest byte.
  return set * 0x0102040810204080 >> 56;
}

// A byte of 1 for each of the lowest eight bits that is set.
std::uint64_t WordOf(std::uint64_t bits) {
  const std::uint64_t own_bit = (bits & 0xff) * kLowBits & 0x8040201008040201;
  return (own_bit + kAllButHighBits) >> 7 & kLowBits;
}

}  // namespace

PixelMask::PixelMask(const Mask& mask) : width_(mask.width()), height_(mask.height()) {
  int u1 = -1;
  int v1 = -1;
  u0_ = width_;
  for (int v = 0; v < height_; ++v) {
    const std::uint8_t* const row = mask.row(v);
    const std::uint8_t* const end = row + width_;
    const std::uint8_t* const first = FirstSet(row, end);
    if (first == end) continue;
    if (v1 < 0) v0_ = v;
    v1 = v;
    u0_ = std::min(u0_, static_cast<int>(first - row));
    u1 = std::max(u1, static_cast<int>(LastSet(first, end) - row));
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
    const std::uint8_t* const row_end = mask.row(v) + u1 + 1;
    for (const std::uint8_t* pixels = mask.row(v) + u0_; pixels < row_end; pixels += kAtOnce) {
      const std::size_t count = std::min(kAtOnce, static_cast<std::size_t>(row_end - pixels));
      const std::uint64_t bits = BitsOf(WordAt(pixels, count));
      bits_[at / 64] |= bits << (at % 64);
      // Only where the next word has some of them: the last word has none behind it.
      if (at % 64 + count > 64) bits_[at / 64 + 1] |= bits >> (64 - at % 64);
      at += count;
    }
  }
}

Mask PixelMask::Unpacked() const {
  Mask mask(width_, height_);
  std::size_t at = 0;
  for (int v = v0_; v < v0_ + window_height_; ++v) {
    std::uint8_t* const row_end = mask.row(v) + u0_ + window_width_;
    for (std::uint8_t* pixels = mask.row(v) + u0_; pixels < row_end; pixels += kAtOnce) {
      const std::size_t count = std::min(kAtOnce, static_cast<std::size_t>(row_end - pixels));
      std::uint64_t bits = bits_[at / 64] >> (at % 64);
      if (at % 64 + count > 64) bits |= bits_[at / 64 + 1] << (64 - at % 64);
      const std::uint64_t word = WordOf(bits);
      if (count == kAtOnce) {
        std::memcpy(pixels, &word, kAtOnce);
      } else {
        std::memcpy(pixels, &word, count);
      }
      at += count;
    }
  }
  return mask;
}

}  // namespace deepslam
