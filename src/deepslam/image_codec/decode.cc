#include "deepslam/image_codec/decode.h"

#include "deepslam/image_codec/jpeg.h"
#include "deepslam/image_codec/png.h"
#include "deepslam/image_codec/structure.h"
#include "deepslam/image_codec/webp.h"

namespace deepslam::image_codec {

Result<ColourImage> DecodeColour(std::string_view bytes) {
  switch (FormatOf(bytes)) {
    case ImageFormat::kPng:
      return DecodePngColour(bytes);
    case ImageFormat::kJpeg:
      return DecodeJpegColour(bytes);
    case ImageFormat::kWebp:
      return DecodeWebp(bytes);
    case ImageFormat::kOther:
      break;
  }
  return InvalidInput("is no PNG, JPEG or WebP image: convert it to PNG");
}

}  // namespace deepslam::image_codec
