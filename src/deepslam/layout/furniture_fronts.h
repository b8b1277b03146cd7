// Furniture that reaches as high as anybody looked, told from walls by where it stands.
#pragma once

#include "deepslam/layout/select_lines.h"

namespace deepslam::layout {

// Takes the runs of wall out that are fronts and sides of wardrobes, and the lines that have no
// other. A front stands before a wall, as far as wardrobes are deep, is no longer than they are,
// and hides the wall and was seen lower than most (`usual_top_m`), as no shaft is, or shows the
// wall under it or over it, as wall cabinets do. Sides join the two.
void DropFurniture(double usual_top_m, WallLines& walls);

}  // namespace deepslam::layout
