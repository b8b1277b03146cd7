// Which lines carry walls.
#pragma once

#include <vector>

#include "deepslam/layout/estimate_layout.h"
#include "deepslam/layout/wall_line.h"
#include "deepslam/layout/wall_profile.h"

namespace deepslam::layout {

struct WallLines {
  std::vector<WallLine> lines;        // by area, largest first
  std::vector<WallProfile> profiles;  // one each
};

// Of lines that planes were found on, those with a wall of some length, seen about as high as most
// wall of the capture (the side of a wardrobe ends lower); of two that face the same way within
// 0.16 m (a wall and what hangs on it, or the recess of its windows), the larger one; without
// fronts of furniture (furniture_fronts.h). Turned to common directions where that is asked for and
// most agree. `floor_m`: the ground, or the lowest surface where none is known.
[[nodiscard]] WallLines SelectLines(const CoarseSurface& surface,
                                    std::vector<WallLine> candidates,
                                    double floor_m,
                                    const LayoutOptions& options);

}  // namespace deepslam::layout
