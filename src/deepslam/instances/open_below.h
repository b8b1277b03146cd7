// Whether a thing is a support plane on legs: tables and desks, whatever a detector calls them.
#pragma once

#include <span>
#include <vector>

#include "deepslam/instances/superpoints.h"
#include "deepslam/instances/surface_elements.h"
#include "deepslam/instances/upright_box.h"

namespace deepslam::instances {

// `own`: the thing's elements, `box_level` round them. True where a level layer makes up most of its
// upper side, little upright surface lies below that, and the floor was seen through it. Things as
// small as nightstands are never said to be open: legs lift those as well.
[[nodiscard]] bool IsOpenBelow(std::span<const int> own,
                               const UprightBox& box_level,
                               const SurfaceElements& elements,
                               const Superpoints& superpoints);

}  // namespace deepslam::instances
