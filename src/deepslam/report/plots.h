// Plots as inline SVG, made from values alone: same values, same text.
#pragma once

#include <span>
#include <string>

#include "deepslam/report/report_content.h"

namespace deepslam::report {

// The room from above, metres: camera path coloured by status (green tracked, orange degenerate,
// red lost), keyframes, the path before the graph as a grey line, objects as turned rectangles with
// their front marked. x right, y up.
[[nodiscard]] std::string TopView(const ReportContent& content);

// Height of the camera above the ground over the frames, m, with the frames' status underneath.
[[nodiscard]] std::string HeightOverTime(std::span<const TrackedFrame> frames);

}  // namespace deepslam::report
