#include "deepslam/dataset/packed_depth.h"

#include <cstddef>
#include <optional>
#include <utility>

#include <blosc.h>

#include "deepslam/core/check.h"

namespace deepslam::dataset {
namespace {

constexpr int kLevel = 5;      // beyond it smaller by little
constexpr int kOneThread = 1;  // frames are packed and unpacked by threads of the caller
constexpr std::size_t kBlocksAsItLikes = 0;  // Blosc chooses a size of blocks that fits the cache

template <typename T>
std::string Pack(const Image<T>& image) {
  const std::size_t num_bytes = image.size() * sizeof(T);
  std::string bytes(num_bytes + BLOSC_MAX_OVERHEAD, '\0');
  const int size = blosc_compress_ctx(kLevel,
                                      BLOSC_SHUFFLE,
                                      sizeof(T),
                                      num_bytes,
                                      image.data(),
                                      bytes.data(),
                                      bytes.size(),
                                      BLOSC_LZ4_COMPNAME,
                                      kBlocksAsItLikes,
                                      kOneThread);
  DEEPSLAM_CHECK(size > 0, "what cannot be made smaller fits all the same");
  return std::string(bytes, 0, static_cast<std::size_t>(size));
}

template <typename T>
Image<T> Unpack(const std::string& bytes, int width, int height) {
  Image<T> image(width, height);
  const std::size_t num_bytes = image.size() * sizeof(T);
  const int size = blosc_decompress_ctx(bytes.data(), image.data(), num_bytes, kOneThread);
  DEEPSLAM_CHECK(size >= 0 && static_cast<std::size_t>(size) == num_bytes,
                 "what was packed here can be unpacked");
  return image;
}

}  // namespace

PackedDepth::PackedDepth(const DepthImage& depth_m, const MetresOfRaw& metres)
    : width_(depth_m.width()), height_(depth_m.height()) {
  if (const std::optional<RawDepthImage> raw = metres.RawOf(depth_m)) {
    metres_ = metres;
    bytes_ = Pack(*raw);
  } else {
    bytes_ = Pack(depth_m);
  }
}

DepthImage PackedDepth::Unpacked() const {
  if (metres_) return metres_->Of(Unpack<std::uint16_t>(bytes_, width_, height_));
  return Unpack<float>(bytes_, width_, height_);
}

}  // namespace deepslam::dataset
