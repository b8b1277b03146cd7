// NumPy's .npy: magic, version, length of a header, the header as a Python dictionary with 'descr',
// 'fortran_order' and 'shape', then the numbers.
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "deepslam/image_codec/depth_formats.h"

namespace deepslam::image_codec {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are taken as they lie");

struct Header {
  int width = 0;
  int height = 0;
  char kind = 0;              // 'f', 'u' or 'i'
  std::size_t num_bytes = 0;  // of a number
  bool swapped = false;       // the higher byte first
  bool by_columns = false;
  std::string_view numbers;
};

// What stands behind 'key': in the dictionary; empty where it does not.
std::string_view Field(std::string_view text, std::string_view key) {
  for (const char quote : {'\'', '"'}) {
    const std::string quoted = quote + std::string(key) + quote;
    const std::size_t at = text.find(quoted);
    if (at == std::string_view::npos) continue;
    std::string_view value = text.substr(at + quoted.size());
    const std::size_t begin = value.find_first_not_of(" :\t");
    return begin == std::string_view::npos ? std::string_view() : value.substr(begin);
  }
  return {};
}

// "(480, 640)", also with a third side of 1.
std::optional<std::vector<std::int64_t>> ParseShape(std::string_view value) {
  if (!value.starts_with('(')) return std::nullopt;
  const std::size_t close = value.find(')');
  if (close == std::string_view::npos) return std::nullopt;
  std::string_view left = value.substr(1, close - 1);
  std::vector<std::int64_t> sides;
  while (true) {
    const std::size_t begin = left.find_first_not_of(" ,");
    if (begin == std::string_view::npos) break;
    left.remove_prefix(begin);
    std::int64_t side = 0;
    const auto [end, code] = std::from_chars(left.data(), left.data() + left.size(), side);
    if (code != std::errc() || sides.size() == 4) return std::nullopt;
    left.remove_prefix(static_cast<std::size_t>(end - left.data()));
    sides.push_back(side);
  }
  return sides;
}

Status ParseKind(std::string_view value, Header& header) {
  if (value.size() < 5) return InvalidInput("NumPy header has no field 'descr'");
  const std::string_view kind = value.substr(1, 3);
  const char order = kind[0];
  header.kind = kind[1];
  header.num_bytes = static_cast<std::size_t>(kind[2] - '0');
  header.swapped = order == '>';
  const bool real = header.kind == 'f' &&
                    (header.num_bytes == 2 || header.num_bytes == 4 || header.num_bytes == 8);
  const bool whole = (header.kind == 'u' || header.kind == 'i') &&
                     (header.num_bytes == 2 || header.num_bytes == 4 || header.num_bytes == 8);
  if ((real || whole) && (order == '<' || order == '>' || order == '=')) return Ok();
  return InvalidInput(
      fmt::format("NumPy array of '{}'; depth is read as float16, float32, float64, or whole "
                  "numbers of 16 bits or more",
                  std::string(kind)));
}

Result<std::string_view> HeaderText(std::string_view bytes, std::size_t& begin_of_numbers) {
  constexpr std::size_t kMagicBytes = 8;  // magic, version
  if (bytes.size() < kMagicBytes + 4)
    return InvalidInput("NumPy header ends too early (truncated?)");
  const int version = static_cast<unsigned char>(bytes[6]);
  if (version < 1 || version > 3)
    return InvalidInput(fmt::format("NumPy file of version {}; 1 to 3 are read", version));
  const std::size_t length_bytes = version == 1 ? 2 : 4;
  std::size_t length = 0;
  for (std::size_t i = length_bytes; i-- > 0;)
    length = length << 8 | static_cast<unsigned char>(bytes[kMagicBytes + i]);
  const std::size_t begin = kMagicBytes + length_bytes;
  if (length > bytes.size() - begin)
    return InvalidInput("NumPy header ends too early (truncated?)");
  begin_of_numbers = begin + length;
  return bytes.substr(begin, length);
}

Result<Header> ReadHeader(std::string_view bytes) {
  std::size_t begin_of_numbers = 0;
  const Result<std::string_view> text = HeaderText(bytes, begin_of_numbers);
  if (!text) return text.error();
  Header header;
  if (const Status kind = ParseKind(Field(*text, "descr"), header); !kind) return kind.error();
  header.by_columns = Field(*text, "fortran_order").starts_with("True");
  std::optional<std::vector<std::int64_t>> sides = ParseShape(Field(*text, "shape"));
  if (!sides) return InvalidInput("NumPy header has no field 'shape'");
  // Sides of 1, in front or behind, are no image's.
  if (sides->size() == 3 && sides->front() == 1) {
    sides->erase(sides->begin());
  } else if (sides->size() == 3 && sides->back() == 1) {
    sides->pop_back();
  }
  if (sides->size() != 2) {
    return InvalidInput(fmt::format(
        "NumPy array of {} sides; a depth image has two, height and width", sides->size()));
  }
  const std::string_view numbers = bytes.substr(begin_of_numbers);
  if (const Status sane = CheckDepthSize((*sides)[1], (*sides)[0], numbers.size(), 1); !sane)
    return sane.error();
  header.height = static_cast<int>((*sides)[0]);
  header.width = static_cast<int>((*sides)[1]);
  const std::size_t num_bytes = header.num_bytes * static_cast<std::size_t>(header.width) *
                                static_cast<std::size_t>(header.height);
  if (numbers.size() < num_bytes) {
    return InvalidInput(fmt::format("has {} bytes of numbers, {} x {} px need {} (truncated?)",
                                    numbers.size(),
                                    header.width,
                                    header.height,
                                    num_bytes));
  }
  header.numbers = numbers.substr(0, num_bytes);
  return header;
}

template <typename T>
T NumberAt(const Header& header, std::size_t index) {
  char raw[sizeof(T)];
  std::memcpy(raw, header.numbers.data() + index * sizeof(T), sizeof(T));
  if (header.swapped) std::reverse(raw, raw + sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

// IEEE 754's numbers of 16 bits.
float OfHalf(std::uint16_t bits) {
  const int exponent = bits >> 10U & 0x1F;
  const int fraction = bits & 0x3FF;
  float size = std::ldexp(static_cast<float>(fraction), -24);
  if (exponent == 31) {
    size = fraction == 0 ? std::numeric_limits<float>::infinity()
                         : std::numeric_limits<float>::quiet_NaN();
  } else if (exponent > 0) {
    size = std::ldexp(static_cast<float>(1024 + fraction), exponent - 25);
  }
  return (bits & 0x8000U) != 0 ? -size : size;
}

float RealAt(const Header& header, std::size_t index) {
  switch (header.num_bytes) {
    case 2:
      return OfHalf(NumberAt<std::uint16_t>(header, index));
    case 4:
      return NumberAt<float>(header, index);
    default:
      return static_cast<float>(NumberAt<double>(header, index));
  }
}

template <typename T>
std::uint16_t Whole(const Header& header, std::size_t index) {
  const T value = NumberAt<T>(header, index);
  return value > 0 && static_cast<std::uint64_t>(value) <= 65535 ? static_cast<std::uint16_t>(value)
                                                                 : std::uint16_t{0};
}

std::uint16_t WholeAt(const Header& header, std::size_t index) {
  const bool is_signed = header.kind == 'i';
  switch (header.num_bytes) {
    case 2:
      return is_signed ? Whole<std::int16_t>(header, index) : Whole<std::uint16_t>(header, index);
    case 4:
      return is_signed ? Whole<std::int32_t>(header, index) : Whole<std::uint32_t>(header, index);
    default:
      return is_signed ? Whole<std::int64_t>(header, index) : Whole<std::uint64_t>(header, index);
  }
}

// Of the pixel (u, v) among the numbers.
std::size_t IndexOf(const Header& header, int u, int v) {
  return header.by_columns ? static_cast<std::size_t>(u) * static_cast<std::size_t>(header.height) +
                                 static_cast<std::size_t>(v)
                           : static_cast<std::size_t>(v) * static_cast<std::size_t>(header.width) +
                                 static_cast<std::size_t>(u);
}

}  // namespace

Result<DepthStructure> NpyStructure(std::string_view bytes) {
  const Result<Header> header = ReadHeader(bytes);
  if (!header) return header.error();
  return DepthStructure{DepthFormat::kNpy, header->width, header->height, header->kind == 'f'};
}

Result<DepthPixels> DecodeNpy(std::string_view bytes) {
  const Result<Header> header = ReadHeader(bytes);
  if (!header) return header.error();
  if (header->kind != 'f') {
    Image<std::uint16_t> image(header->width, header->height);
    for (int v = 0; v < image.height(); ++v) {
      for (int u = 0; u < image.width(); ++u)
        image(u, v) = WholeAt(*header, IndexOf(*header, u, v));
    }
    return DepthPixels(std::move(image));
  }
  Image<float> image(header->width, header->height);
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) image(u, v) = RealAt(*header, IndexOf(*header, u, v));
  }
  return DepthPixels(std::move(image));
}

}  // namespace deepslam::image_codec
