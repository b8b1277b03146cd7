// A model set straight by the object's own measurement.
#pragma once

#include "deepslam/geometry/pose.h"

namespace deepslam::modelling {

// The model's pose turned about its own vertical (z) so that its sides are parallel to those of the
// measured box, where they are 2 to 10 degrees off. Of sides that are nearer to parallel the
// registration knows more than a box, and farther off the two are no sides of one thing.
[[nodiscard]] Pose3 TurnedAlong(const Pose3& world_from_object, const Pose3& world_from_measured);

}  // namespace deepslam::modelling
