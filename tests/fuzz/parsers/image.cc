// Colour images of a capture, PNG and JPEG, for a camera of 8 x 6 px.
#include "deepslam/dataset/image_files.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(image) {
  constexpr int kWidth = 8;
  constexpr int kHeight = 6;
  const auto image = dataset::DecodeColour(bytes, kFile, kWidth, kHeight);
  if (!image.ok()) return Refused(image.error());
  DEEPSLAM_CHECK(image->width() == kWidth && image->height() == kHeight,
                 "an image is the camera's");
  return true;
}
