// What a user may have meant by a name that is not known.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace deepslam {

// The one of `known` with the fewest edits (letters changed, added, left out) to `word`; empty when
// none is near.
[[nodiscard]] std::string NearestWord(std::string_view word, std::span<const std::string> known);

}  // namespace deepslam
