// Depth in the formats that recorders write: PNG, PGM, TIFF, OpenEXR, NumPy.
#include "deepslam/image_codec/depth_image.h"

#include "fuzz/entry.h"

DEEPSLAM_FUZZ(depth_image) {
  const auto structure = image_codec::DepthStructureOf(bytes);
  const auto pixels = image_codec::DecodeDepth(bytes);
  if (!structure.ok()) {
    DEEPSLAM_CHECK(!structure.error().message.empty(), "a refusal says why");
    DEEPSLAM_CHECK(!pixels.ok(), "what has no size has no pixels");
    return false;
  }
  if (!pixels.ok()) return false;
  const auto of_size = [&](const auto& image) {
    DEEPSLAM_CHECK(image.width() == structure->width && image.height() == structure->height,
                   "pixels are of the size that the header says");
  };
  std::visit(of_size, *pixels);
  DEEPSLAM_CHECK(std::holds_alternative<Image<float>>(*pixels) == structure->real,
                 "pixels are of the kind that the header says");
  return true;
}
