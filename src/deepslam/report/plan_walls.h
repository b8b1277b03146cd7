// Walls and openings of a floor plan, as SVG.
#pragma once

#include <string>

#include "deepslam/report/floor_plan.h"
#include "deepslam/scene/layout.h"

namespace deepslam::report {

// Walls filled over their thickness, sides of rooms that were not seen as dashed lines.
[[nodiscard]] std::string PlanWalls(const PlanCanvas& canvas, const Layout& layout);

// What opens them, drawn over them; what is doubtful with dashes.
[[nodiscard]] std::string PlanOpenings(const PlanCanvas& canvas, const Layout& layout);

}  // namespace deepslam::report
