// What tells a support plane on legs: tables and desks, whatever a detector calls them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "deepslam/instances/superpoints.h"
#include "deepslam/instances/surface_elements.h"
#include "deepslam/instances/upright_box.h"

namespace deepslam::instances {

// `own`: the thing's elements, `box_level` round them. The height of a level layer that makes up
// most of its upper side; none where there is none, and of things as small as nightstands and
// stools.
[[nodiscard]] std::optional<double> LevelFaceHeight(std::span<const int> own,
                                                    const UprightBox& box_level,
                                                    const SurfaceElements& elements);

// Whether there is such a layer and little upright surface below it. Of nightstands there is none:
// legs lift those as well.
[[nodiscard]] bool IsTopOnLegs(std::span<const int> own,
                               const UprightBox& box_level,
                               const SurfaceElements& elements);

// Whether half of the floor within the box was seen, as under tables.
[[nodiscard]] bool IsFloorSeenIn(const UprightBox& box_level,
                                 const SurfaceElements& elements,
                                 const Superpoints& superpoints);

}  // namespace deepslam::instances
