// Depth images of .sens files. The first byte is the codec, then sides as two bytes each.
#include "deepslam/formats/sens_codecs.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(sens_depth) {
  if (bytes.size() < 5) return false;
  const auto at = [&](std::size_t i) {
    return static_cast<int>(static_cast<unsigned char>(bytes[i]));
  };
  const auto codec = static_cast<formats::SensDepthCodec>(at(0) % 4 - 1);
  const int width = 1 + (at(1) | at(2) << 8) % 16384;
  const int height = 1 + (at(3) | at(4) << 8) % 16384;
  const auto depth = formats::UnpackDepth(codec, bytes.substr(5), width, height);
  if (!depth.ok()) return Refused(depth.error(), "depth");
  DEEPSLAM_CHECK(depth->width() == width && depth->height() == height,
                 "depth is of the size asked");
  const Result<std::string> packed = formats::PackDepthZlib(*depth);
  DEEPSLAM_CHECK(packed.ok(), "depth can be packed");
  const auto again = formats::UnpackDepth(formats::SensDepthCodec::kZlib, *packed, width, height);
  DEEPSLAM_CHECK(again.ok() && *again == *depth, "packing loses nothing");
  return true;
}
