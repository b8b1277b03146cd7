// The report page of one capture: one self-contained HTML file that opens from disk, no network.
//
// The page is a function of its content alone, so that reruns are byte-equal. Times are not
// content: the page loads
// `../timing.js`, which the runner writes after every run, where that file lies there.
#pragma once

#include <string>

#include "deepslam/report/report_content.h"

namespace deepslam::report {

[[nodiscard]] std::string RenderReport(const ReportContent& content);

}  // namespace deepslam::report
