// Doors, windows and passages in a wall's face.
#pragma once

#include <string>
#include <vector>

#include "deepslam/layout/wall_profile.h"
#include "deepslam/scene/layout.h"

namespace deepslam::layout {

// A face between two corners.
struct WallFace {
  double from_m = 0;  // along the line
  double to_m = 0;
  double floor_m = 0;
  double top_m = 0;  // the ceiling, or as high as the wall was seen
  bool ceiling_seen = false;
};

struct FaceOpening {
  OpeningKind kind = OpeningKind::kDoor;
  double from_m = 0;  // along the line
  double to_m = 0;
  double bottom_m = 0;
  double top_m = 0;
  double confidence = 0;
  std::string note;
};

// By position. Gaps that rays went through or in which nothing was measured (glass), with wall at
// two sides at least; leaves that lie deeper than the wall or have a casing around them, as closed
// doors do; and what is set back with wall all around, as panes and blinds of windows are.
[[nodiscard]] std::vector<FaceOpening> FindOpenings(const WallProfile& profile,
                                                    const WallFace& face);

}  // namespace deepslam::layout
