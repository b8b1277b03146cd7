#include "deepslam/frames/pixel_mask.h"

#include <utility>

#include "deepslam/frames/run_lengths.h"

namespace deepslam {

PixelMask::PixelMask(int width, int height, std::string rle)
    : width_(width), height_(height), rle_(std::move(rle)) {}

PixelMask::PixelMask(const Mask& mask) : PixelMask(mask.width(), mask.height(), EncodeRle(mask)) {}

Result<PixelMask> PixelMask::FromRle(std::string_view counts, int width, int height) {
  Result<std::string> rle = CanonicalRle(counts, width, height);
  if (!rle.ok()) return rle.error();
  return PixelMask(width, height, std::move(rle).value());
}

Mask PixelMask::Unpacked() const {
  return empty() ? Mask(width_, height_) : DecodeRle(rle_, width_, height_).value();
}

}  // namespace deepslam
