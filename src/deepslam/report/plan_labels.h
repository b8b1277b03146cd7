// Names and measures of a floor plan, as SVG.
#pragma once

#include <string>

#include "deepslam/report/floor_plan.h"

namespace deepslam::report {

// Of furniture (name and measures, in its outline), openings (width and height, in the wall),
// walls (length, beside the face) and rooms (name, area and height, where there is most place).
// Each stands at the first of its places where no other stands; a length that has none is left out.
[[nodiscard]] std::string PlanLabels(const PlanCanvas& canvas, const FloorPlanContent& content);

}  // namespace deepslam::report
