// Furniture that stands as high as anybody looked, told from walls by where it stands.
#pragma once

#include "deepslam/layout/select_lines.h"

namespace deepslam::layout {

// Takes the runs of wall out that are fronts and sides of wardrobes, and the lines that have no
// other. A front stands before a wall, as far as wardrobes are deep, and hides it, is no longer
// than they are, and was seen lower than most wall (`usual_top_m`); a shaft is seen as high as the
// walls beside it. Sides join the two.
void DropWardrobes(double usual_top_m, WallLines& walls);

}  // namespace deepslam::layout
