// The page's part about the objects: a table of all, then each with photographs and candidates.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "deepslam/report/report_content.h"

namespace deepslam::report {

[[nodiscard]] std::string ObjectSection(const ReportContent& content);

// Pictures side by side, with their captions.
[[nodiscard]] std::string Gallery(const std::vector<Picture>& pictures,
                                  std::string_view extra_class);
[[nodiscard]] std::string Figure(const Picture& picture);

}  // namespace deepslam::report
