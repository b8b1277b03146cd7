#include "deepslam/core/identifiers.h"

#include <cctype>
#include <cstddef>
#include <cstdint>

#include "deepslam/core/utf8.h"

namespace deepslam {
namespace {

// The code point at `at` of valid UTF-8; `at` moves behind it.
std::uint32_t TakeCodePoint(std::string_view text, std::size_t& at) {
  const auto byte = [&](std::size_t n) { return static_cast<std::uint32_t>(text[n] & 0xFF); };
  const std::uint32_t first = byte(at++);
  if (first < 0x80) return first;
  const std::size_t more = first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : 1;
  std::uint32_t point = first & (0x3FU >> more);
  for (std::size_t n = 0; n < more && at < text.size(); ++n)
    point = (point << 6) | (byte(at++) & 0x3F);
  return point;
}

// "_u00FC".
std::string Escaped(std::uint32_t point) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string digits;
  for (; point != 0 || digits.size() < 4; point >>= 4) digits.insert(0, 1, kDigits[point & 0xFU]);
  return "_u" + digits;
}

bool IsPlain(std::uint32_t point) {
  return point < 0x80 && (std::isalnum(static_cast<int>(point)) != 0 || point == '_');
}

}  // namespace

std::string IdentifierOf(std::string_view name) {
  const std::string text = ToValidUtf8(name);
  std::string identifier;
  for (std::size_t at = 0; at < text.size();) {
    const std::uint32_t point = TakeCodePoint(text, at);
    if (IsPlain(point)) {
      identifier += static_cast<char>(point);
    } else {
      identifier += Escaped(point);
    }
  }
  const bool bad_front =
      identifier.empty() || std::isdigit(static_cast<unsigned char>(identifier.front())) != 0;
  return bad_front ? "_" + identifier : identifier;
}

std::string Identifiers::Take(std::string_view name) {
  const std::string base = IdentifierOf(name);
  std::string identifier = base;
  for (int n = 2; !taken_.insert(identifier).second; ++n)
    identifier = base + "_" + std::to_string(n);
  return identifier;
}

}  // namespace deepslam
