// Text for web pages.
#pragma once

#include <string>
#include <string_view>

namespace deepslam::report {

// `text` with &, <, >, " and ' replaced, so that names from outside cannot become markup.
[[nodiscard]] std::string EscapeHtml(std::string_view text);

}  // namespace deepslam::report
