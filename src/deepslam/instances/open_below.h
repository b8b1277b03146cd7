// What tells a support plane on legs: tables and desks, whatever a detector calls them.
#pragma once

#include <span>
#include <vector>

#include "deepslam/instances/superpoints.h"
#include "deepslam/instances/surface_elements.h"
#include "deepslam/instances/upright_box.h"

namespace deepslam::instances {

// `own`: the thing's elements, `box_level` round them. True where a level layer makes up most of
// its upper side and little upright surface lies below that. Things as small as nightstands never
// are: legs lift those as well.
[[nodiscard]] bool IsTopOnLegs(std::span<const int> own,
                               const UprightBox& box_level,
                               const SurfaceElements& elements);

// Whether half of the floor within the box was seen, as under tables.
[[nodiscard]] bool IsFloorSeenIn(const UprightBox& box_level,
                                 const SurfaceElements& elements,
                                 const Superpoints& superpoints);

}  // namespace deepslam::instances
