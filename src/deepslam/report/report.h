// The report page of one capture: one self-contained HTML file that opens from disk, no network.
//
// The page is a function of its content alone, so that reruns are byte-equal. Times are not
// content: a hidden frame opens `../timing.html`, which the runner writes after every run and which
// posts {deepslamTiming: [{stage, wall_s, cpu_s, peak_mb, reused}]} to the page. Without that file
// the page says that it has no times.
#pragma once

#include <string>

#include "deepslam/report/report_content.h"

namespace deepslam::report {

[[nodiscard]] std::string RenderReport(const ReportContent& content);

}  // namespace deepslam::report
