// How deep a closed thing is of which little but the front was seen: to the wall behind it.
#pragma once

#include <optional>
#include <span>

#include "deepslam/instances/surface_elements.h"
#include "deepslam/instances/upright_box.h"
#include "deepslam/scene/layout.h"

namespace deepslam::instances {

// The box with its back at the wall that it stands before, if that is no farther than furniture is
// deep. Nothing where no wall is, where it does not rise above the box, where the box faces another
// way (`facing`: the sum of its elements' normals), or where some surface was seen between the two:
// wall or floor behind a leaf or a screen. All in the level world.
[[nodiscard]] std::optional<UprightBox> ReachBack(const UprightBox& box,
                                                  const Eigen::Vector3f& facing,
                                                  std::span<const LayoutWall> walls,
                                                  const SurfaceElements& elements);

}  // namespace deepslam::instances
