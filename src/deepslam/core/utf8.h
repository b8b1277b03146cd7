// Valid UTF-8 out of any bytes: JSON can hold nothing else.
#pragma once

#include <string>
#include <string_view>

namespace deepslam {

// Bytes that are no UTF-8 (overlong forms and surrogates included) become U+FFFD; NUL too, since C
// readers stop there.
[[nodiscard]] std::string ToValidUtf8(std::string_view text);

}  // namespace deepslam
