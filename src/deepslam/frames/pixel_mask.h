// The pixels of one thing in an image, kept small: a capture has tens of thousands of them. Their
// run lengths, as artifacts hold them too (frames/run_lengths.h): as large an image as it is, a
// mask costs what the thing's outline does.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/image.h"
#include "deepslam/core/result.h"

namespace deepslam {

class PixelMask {
 public:
  PixelMask() = default;
  PixelMask(const Mask& mask);  // NOLINT(google-explicit-constructor): the same in another form

  // Refuses what DecodeRle refuses.
  [[nodiscard]] static Result<PixelMask> FromRle(std::string_view counts, int width, int height);

  // Of the image.
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool empty() const { return width_ == 0 || height_ == 0; }
  // As EncodeRle gives it.
  [[nodiscard]] const std::string& rle() const { return rle_; }
  // 1 where the pixel belongs to it.
  [[nodiscard]] Mask Unpacked() const;

  friend bool operator==(const PixelMask&, const PixelMask&) = default;

 private:
  PixelMask(int width, int height, std::string rle);

  int width_ = 0;
  int height_ = 0;
  std::string rle_;
};

}  // namespace deepslam
