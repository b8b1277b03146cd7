// The page's 3D view: its markup, the scene and what the script needs to know of the objects.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/report/report_content.h"

namespace deepslam::report {

// Style rules of the view.
[[nodiscard]] std::string_view ViewerStyle();

// The view with its data, all inline; a sentence in its place when there is no scene, when the
// scene is too large for a page, or when the program was built without the view.
[[nodiscard]] std::string ViewerSection(const ReportContent& content);

// The script; stands at the end of the page. Empty where the section has no view.
[[nodiscard]] std::string ViewerScript(const ReportContent& content);

// What the script reads, as JSON that is safe inside a script element: {"objects": [{name, class,
// colour, confidence, views, size_m, source, credit, note, why, candidates, points: {origin_m,
// data}}], "layout": {"rooms": [{name, middle_m}], "walls": [{from_m, to_m}]}, "trajectory_m": [[x,
// y, z]], "tracked_m": [...]}; world axes of the report, z up. Points are 16-bit millimetres above
// origin_m, little endian, base64.
[[nodiscard]] std::string ViewerData(const ReportContent& content);

}  // namespace deepslam::report
