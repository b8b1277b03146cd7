// Texts in double quotes as YAML has them.
#pragma once

#include <string>
#include <string_view>

namespace deepslam {

// Reads back as the same text, line breaks and other control characters included.
[[nodiscard]] std::string DoubleQuotedYaml(std::string_view text);

// Bare, YAML reads it as no value at all.
[[nodiscard]] bool IsNullYaml(std::string_view text);

}  // namespace deepslam
