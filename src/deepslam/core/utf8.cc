#include "deepslam/core/utf8.h"

#include <cstddef>
#include <cstdint>

namespace deepslam {
namespace {

unsigned ByteAt(std::string_view text, std::size_t at) {
  return at < text.size() ? static_cast<unsigned char>(text[at]) : 0U;
}

// Length of the valid sequence at `at`; 0 when there is none.
std::size_t SequenceLength(std::string_view text, std::size_t at) {
  const unsigned first = ByteAt(text, at);
  if (first == 0) return 0;
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC2 ? 2 : 0;
  if (length == 0 || first > 0xF4) return 0;
  std::uint32_t code = first & (0x7FU >> length);
  for (std::size_t n = 1; n < length; ++n) {
    const unsigned next = ByteAt(text, at + n);
    if ((next & 0xC0U) != 0x80U) return 0;
    code = (code << 6U) | (next & 0x3FU);
  }
  const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  return overlong || surrogate || code > 0x10FFFF ? 0 : length;
}

void AppendUtf8(std::uint32_t code, std::string& text) {
  const auto put = [&](std::uint32_t byte) { text.push_back(static_cast<char>(byte)); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xC0U | code >> 6U);
    put(0x80U | (code & 0x3FU));
  } else if (code < 0x10000) {
    put(0xE0U | code >> 12U);
    put(0x80U | (code >> 6U & 0x3FU));
    put(0x80U | (code & 0x3FU));
  } else {
    put(0xF0U | code >> 18U);
    put(0x80U | (code >> 12U & 0x3FU));
    put(0x80U | (code >> 6U & 0x3FU));
    put(0x80U | (code & 0x3FU));
  }
}

// Stands for what is no character.
constexpr std::uint32_t kReplacement = 0xFFFD;  // Unicode's replacement character

// Units of 16 bits, the lower or the higher byte first. Halves of pairs without the other become
// U+FFFD.
std::string OfUtf16(std::string_view bytes, bool high_first) {
  std::string text;
  std::uint32_t high = 0;
  for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) {
    const std::uint32_t unit = high_first ? ByteAt(bytes, at) << 8U | ByteAt(bytes, at + 1)
                                          : ByteAt(bytes, at + 1) << 8U | ByteAt(bytes, at);
    const bool is_high = unit >= 0xD800 && unit < 0xDC00;
    const bool is_low = unit >= 0xDC00 && unit < 0xE000;
    if (high != 0 && !is_low) AppendUtf8(kReplacement, text);
    if (is_low) {
      AppendUtf8(high == 0 ? kReplacement : 0x10000 + ((high - 0xD800) << 10U) + (unit - 0xDC00),
                 text);
    } else if (!is_high) {
      AppendUtf8(unit, text);
    }
    high = is_high ? unit : 0;
  }
  if (high != 0) AppendUtf8(kReplacement, text);
  return text;
}

// Units of 32 bits; what is no character becomes U+FFFD.
std::string OfUtf32(std::string_view bytes, bool high_first) {
  std::string text;
  for (std::size_t at = 0; at + 3 < bytes.size(); at += 4) {
    std::uint32_t code = 0;
    for (std::size_t k = 0; k < 4; ++k)
      code = code << 8U | ByteAt(bytes, at + (high_first ? k : 3 - k));
    const bool is_character = code < 0x110000 && !(code >= 0xD800 && code < 0xE000);
    AppendUtf8(is_character ? code : kReplacement, text);
  }
  return text;
}

// Lists and settings begin with characters of ASCII, of which UTF-16 keeps one byte as zero.
bool StartsAsUtf16(std::string_view bytes, bool high_first) {
  constexpr std::size_t kLookedAt = 8;  // four characters
  if (bytes.size() < kLookedAt) return false;
  for (std::size_t at = 0; at < kLookedAt; ++at) {
    const bool is_high = (at % 2 == 0) == high_first;
    if ((ByteAt(bytes, at) == 0) != is_high) return false;
  }
  return true;
}

}  // namespace

std::string Utf8OfText(std::string bytes) {
  using std::string_view_literals::operator""sv;
  if (bytes.starts_with("\xFF\xFE\0\0"sv)) return OfUtf32(std::string_view(bytes).substr(4), false);
  if (bytes.starts_with("\0\0\xFE\xFF"sv)) return OfUtf32(std::string_view(bytes).substr(4), true);
  if (bytes.starts_with("\xFF\xFE")) return OfUtf16(std::string_view(bytes).substr(2), false);
  if (bytes.starts_with("\xFE\xFF")) return OfUtf16(std::string_view(bytes).substr(2), true);
  for (const bool high_first : {false, true})
    if (StartsAsUtf16(bytes, high_first)) return OfUtf16(bytes, high_first);
  return bytes;
}

std::string ToValidUtf8(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = SequenceLength(text, at);
    if (length == 0) {
      result += "\xEF\xBF\xBD";
      ++at;
    } else {
      result += text.substr(at, length);
      at += length;
    }
  }
  return result;
}

}  // namespace deepslam
