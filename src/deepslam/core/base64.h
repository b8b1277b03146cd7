// Bytes inside text (RFC 4648, with padding).
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"

namespace deepslam {

[[nodiscard]] std::string EncodeBase64(std::string_view bytes);
// Refuses foreign characters, bad padding and lengths.
[[nodiscard]] Result<std::string> DecodeBase64(std::string_view text);

}  // namespace deepslam
