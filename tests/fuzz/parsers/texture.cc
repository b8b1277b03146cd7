// Textures of furniture: PNG, JPEG and WebP of any size.
#include "deepslam/image_codec/decode.h"
#include "deepslam/image_codec/png.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(texture) {
  const auto image = image_codec::DecodeColour(bytes);
  if (!image.ok()) return Refused(image.error(), "");
  DEEPSLAM_CHECK(image->width() > 0 && image->height() > 0, "an image has pixels");
  const auto again = image_codec::DecodePngColour(*image_codec::EncodePng(*image));
  DEEPSLAM_CHECK(again.ok() && *again == *image,
                 "what was read can be written and reads as the same");
  return true;
}
