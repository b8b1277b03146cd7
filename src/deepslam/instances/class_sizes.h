// Whether a box is one that things of a class have.
#pragma once

#include "deepslam/instances/upright_box.h"
#include "deepslam/scene/object_class.h"

namespace deepslam::instances {

// No larger or higher than they are, and at least half as long as the least of them: what was seen
// of a thing may be less than all of it.
[[nodiscard]] bool MayBe(const ObjectClass& object_class, const UprightBox& box);

}  // namespace deepslam::instances
