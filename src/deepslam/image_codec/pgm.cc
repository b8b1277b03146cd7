// PGM ("P5"): a header of words, comments behind '#', then rows from the top. Values beyond 8 bits
// take two bytes, the higher one first.
#include <charconv>
#include <optional>

#include <fmt/format.h>

#include "deepslam/image_codec/depth_formats.h"

namespace deepslam::image_codec {
namespace {

struct Header {
  int width = 0;
  int height = 0;
  std::string_view pixels;
};

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

// The number at the front, which it leaves; nothing where none stands.
std::optional<int> TakeNumber(std::string_view& left) {
  while (!left.empty() && (IsBlank(left.front()) || left.front() == '#')) {
    if (left.front() == '#') {
      left.remove_prefix(std::min(left.find('\n'), left.size()));
    } else {
      left.remove_prefix(1);
    }
  }
  int number = 0;
  const auto [end, code] = std::from_chars(left.data(), left.data() + left.size(), number);
  if (code != std::errc() || number < 0) return std::nullopt;
  left.remove_prefix(static_cast<std::size_t>(end - left.data()));
  return number;
}

Result<Header> ReadHeader(std::string_view bytes) {
  std::string_view left = bytes.substr(2);
  const std::optional<int> width = TakeNumber(left);
  const std::optional<int> height = width ? TakeNumber(left) : std::nullopt;
  const std::optional<int> highest = height ? TakeNumber(left) : std::nullopt;
  if (!highest || left.empty() || !IsBlank(left.front()))
    return InvalidInput("PGM header ends too early (truncated or damaged)");
  if (*highest < 256 || *highest > 65535) {
    return InvalidInput(
        fmt::format("PGM of values up to {}: depth must have 16 bits (256 .. 65535)", *highest));
  }
  left.remove_prefix(1);
  if (const Status sane = CheckDepthSize(*width, *height, left.size(), 1); !sane)
    return sane.error();
  const std::size_t num_bytes =
      2 * static_cast<std::size_t>(*width) * static_cast<std::size_t>(*height);
  if (left.size() < num_bytes) {
    return InvalidInput(fmt::format("has {} bytes of pixels, {} x {} px need {} (truncated?)",
                                    left.size(),
                                    *width,
                                    *height,
                                    num_bytes));
  }
  return Header{*width, *height, left.substr(0, num_bytes)};
}

}  // namespace

Result<DepthStructure> PgmStructure(std::string_view bytes) {
  const Result<Header> header = ReadHeader(bytes);
  if (!header) return header.error();
  return DepthStructure{DepthFormat::kPgm, header->width, header->height, false};
}

Result<DepthPixels> DecodePgm(std::string_view bytes) {
  const Result<Header> header = ReadHeader(bytes);
  if (!header) return header.error();
  Image<std::uint16_t> image(header->width, header->height);
  const char* byte = header->pixels.data();
  for (std::uint16_t& pixel : image) {
    pixel = static_cast<std::uint16_t>(static_cast<unsigned char>(byte[0]) << 8 |
                                       static_cast<unsigned char>(byte[1]));
    byte += 2;
  }
  return DepthPixels(std::move(image));
}

}  // namespace deepslam::image_codec
