// Valid UTF-8 out of any bytes: JSON can hold nothing else; and UTF-8 out of text files.
#pragma once

#include <string>
#include <string_view>

namespace deepslam {

// Bytes that are no UTF-8 (overlong forms and surrogates included) become U+FFFD; NUL too, since C
// readers stop there.
[[nodiscard]] std::string ToValidUtf8(std::string_view text);

// A text file's content as UTF-8: UTF-16 and UTF-32 with a byte order mark (what editors of Windows
// call Unicode), and UTF-16 without one, are turned to UTF-8, other bytes stay as they are.
[[nodiscard]] std::string Utf8OfText(std::string bytes);

}  // namespace deepslam
