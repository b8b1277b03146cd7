// The room itself, from the coarse surface of a whole capture: walls, rooms, openings, levels.
#pragma once

#include "deepslam/core/options.h"
#include "deepslam/layout/surface_planes.h"
#include "deepslam/layout/wall_line.h"
#include "deepslam/layout/wall_profile.h"
#include "deepslam/scene/coarse_surface.h"
#include "deepslam/scene/layout.h"

namespace deepslam::layout {

struct LayoutOptions {
  PlaneOptions planes;
  LineOptions lines;
  ProfileOptions profiles;
  double min_wall_m = 0.4;      // shorter lines of wall are not looked for,
  double min_slanting_m = 1.2;  // nor shorter ones at odd angles where walls are at right angles
  // A wall was seen at least this high above the floor: the backs of sofas, counters and desks end
  // below.
  static constexpr double kMinWallTop_m = 1.2;
  double min_room_m2 = 1.5;  // smaller rooms are none
  // Of a room's area that was seen as its inside; of what was seen less the outline is a guess.
  static constexpr double kMinRoomSeen = 0.35;
  bool align = true;  // walls nearly at right angles are made so where most agree
};
void Describe(OptionsVisitor& visitor, LayoutOptions& options);

// Claims less where less is known: a surface without ground has walls but no rooms, one without
// walls has none of both; `notes` say why. The same whatever the number of threads.
[[nodiscard]] Layout EstimateLayout(const CoarseSurface& surface, const LayoutOptions& options);

}  // namespace deepslam::layout
