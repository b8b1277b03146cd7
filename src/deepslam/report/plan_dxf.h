// The floor plan of a map as DXF for CAD programs: metres, x and y of the map's world.
#pragma once

#include <string>

#include "deepslam/report/floor_plan.h"

namespace deepslam::report {

// Layers WALLS (faces; outer faces that were not seen are drawn at an inner wall's thickness, sides
// of rooms that were not seen are dashed), DOORS (with leaf and arc; passages dashed), WINDOWS,
// FURNITURE (outlines, with the front side) and TEXT (rooms with areas and heights, lengths of
// walls, names). Same content, same text.
[[nodiscard]] std::string FloorPlanDxf(const FloorPlanContent& content);

}  // namespace deepslam::report
