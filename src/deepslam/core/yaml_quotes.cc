#include "deepslam/core/yaml_quotes.h"

namespace deepslam {

std::string DoubleQuotedYaml(std::string_view text) {
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') quoted += '\\';
    // Raw line breaks would be read back as blanks.
    if (code < 0x20 || code == 0x7F) {
      quoted += "\\x";
      quoted += kHex[code / 16];
      quoted += kHex[code % 16];
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

bool IsNullYaml(std::string_view text) {
  return text.empty() || text == "~" || text == "null" || text == "Null" || text == "NULL";
}

}  // namespace deepslam
