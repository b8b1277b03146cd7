// Run-length masks. Width and height come first, two bytes each.
#include "deepslam/frames/pixel_mask.h"
#include "deepslam/frames/run_lengths.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(mask) {
  if (bytes.size() < 4) return false;
  const auto side = [&](std::size_t i) {
    return static_cast<int>(static_cast<unsigned char>(bytes[i])) |
           static_cast<int>(static_cast<unsigned char>(bytes[i + 1])) << 8;
  };
  const auto mask = DecodeRle(bytes.substr(4), side(0), side(2));
  if (!mask.ok()) return Refused(mask.error(), "mask");
  const auto again = DecodeRle(EncodeRle(*mask), side(0), side(2));
  DEEPSLAM_CHECK(again.ok() && *again == *mask, "coding loses nothing");
  const auto kept = PixelMask::FromRle(bytes.substr(4), side(0), side(2));
  DEEPSLAM_CHECK(kept.ok() && *kept == PixelMask(*mask) && kept->Unpacked() == *mask,
                 "runs cut into others are the same mask");
  return true;
}
