#include "deepslam/formats/sens_codecs.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include <fmt/format.h>

namespace deepslam::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "raw values are stored little-endian");

// What a byte of a stream can stand for at most: deflate's longest match in its shortest code, and
// a run of 36 values in 8 bits.
constexpr std::size_t kMaxDeflateRatio = 1032;
constexpr std::size_t kMaxOcciValuesPerByte = 36;  // see above: 5 + 31 repeats

// 9.73 m: the last that the Structure Sensor's table has (header).
constexpr int kMaxSensorShift = 1104;

std::size_t NumPixels(int width, int height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

Error TooShort(std::string_view bytes, int width, int height) {
  return InvalidInput(fmt::format(
      "depth of {} x {} px cannot come from {} bytes (truncated?)", width, height, bytes.size()));
}

Result<RawDepthImage> UnpackRaw(std::string_view bytes, int width, int height) {
  if (bytes.size() != NumPixels(width, height) * sizeof(std::uint16_t))
    return TooShort(bytes, width, height);
  RawDepthImage depth(width, height);
  std::memcpy(depth.data(), bytes.data(), bytes.size());
  return depth;
}

Result<RawDepthImage> UnpackZlib(std::string_view bytes, int width, int height) {
  const std::size_t size = NumPixels(width, height) * sizeof(std::uint16_t);
  if (size > kMaxDeflateRatio * bytes.size()) return TooShort(bytes, width, height);
  RawDepthImage depth(width, height);
  uLongf written = size;
  const int code = ::uncompress(reinterpret_cast<Bytef*>(depth.data()),
                                &written,
                                reinterpret_cast<const Bytef*>(bytes.data()),
                                bytes.size());
  if (code != Z_OK || written != size) {
    return InvalidInput(fmt::format(
        "depth's zlib stream is damaged or not of {} x {} px ({})", width, height, ::zError(code)));
  }
  return depth;
}

// Most significant bit first.
class BitReader {
 public:
  explicit BitReader(std::string_view bytes) : bytes_(bytes) {}

  // Past the end reads as zeros; `exhausted` tells.
  int Take(int count) {
    int value = 0;
    for (int i = 0; i < count; ++i, ++at_) {
      value <<= 1;
      if (at_ / 8 >= bytes_.size()) continue;
      value |= static_cast<unsigned char>(bytes_[at_ / 8]) >> (7 - at_ % 8) & 1;
    }
    return value;
  }
  [[nodiscard]] bool exhausted() const { return at_ > 8 * bytes_.size(); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;  // bits
};

// 00: the last value again; 11, 10: one more, one less; 01101, 01100: two more, two less; 010 and 5
// bits n: the last value n + 5 times; 0111 and 11 bits: this value. The first "last value" is 0.
Result<RawDepthImage> UnpackOcci(std::string_view bytes, int width, int height) {
  const std::size_t count = NumPixels(width, height);
  if (count > kMaxOcciValuesPerByte * bytes.size()) return TooShort(bytes, width, height);
  RawDepthImage depth(width, height);
  BitReader bits(bytes);
  int value = 0;
  for (std::size_t i = 0; i < count;) {
    std::size_t repeat = 1;
    if (bits.Take(1) == 1) {
      value += bits.Take(1) == 1 ? 1 : -1;
    } else if (bits.Take(1) == 1) {
      if (bits.Take(1) == 0) {
        repeat = static_cast<std::size_t>(bits.Take(5)) + 5;
      } else if (bits.Take(1) == 0) {
        value += bits.Take(1) == 1 ? 2 : -2;
      } else {
        value = bits.Take(11);
      }
    }
    if (bits.exhausted() || repeat > count - i)
      return InvalidInput(fmt::format("depth's bit stream is damaged at pixel {} of {}", i, count));
    const std::uint16_t depth_mm = ShiftToMillimetres(value);
    for (; repeat > 0; --repeat) depth.data()[i++] = depth_mm;
  }
  return depth;
}

}  // namespace

Result<RawDepthImage> UnpackDepth(SensDepthCodec codec,
                                  std::string_view bytes,
                                  int width,
                                  int height) {
  switch (codec) {
    case SensDepthCodec::kRaw:
      return UnpackRaw(bytes, width, height);
    case SensDepthCodec::kZlib:
      return UnpackZlib(bytes, width, height);
    case SensDepthCodec::kOcci:
      return UnpackOcci(bytes, width, height);
    case SensDepthCodec::kUnknown:
      break;
  }
  return InvalidInput("depth has an unknown codec");
}

Result<std::string> PackDepthZlib(const RawDepthImage& depth) {
  const uLong size = depth.size() * sizeof(std::uint16_t);
  std::string packed(::compressBound(size), '\0');
  uLongf written = packed.size();
  if (::compress2(reinterpret_cast<Bytef*>(packed.data()),
                  &written,
                  reinterpret_cast<const Bytef*>(depth.data()),
                  size,
                  Z_DEFAULT_COMPRESSION) != Z_OK) {
    return Failed("depth cannot be compressed");
  }
  packed.resize(written);
  return packed;
}

std::uint16_t ShiftToMillimetres(int shift) {
  if (shift < 1 || shift > kMaxSensorShift) return 0;
  return static_cast<std::uint16_t>(6 * 300000 / (6809 - 6 * shift));
}

}  // namespace deepslam::formats
