// How objects move with the cameras that saw them, from one path to another.
#pragma once

#include <Eigen/Core>

#include "deepslam/scene/object_map.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::modelling {

// How what the object's best view saw moves from one path to another; without views: not at all.
[[nodiscard]] Pose3 MovedWith(const Trajectory& before,
                              const Trajectory& after,
                              const MapObject& object);

// The largest distance by which that moves what a view saw of the object against what its best view
// saw: views of both ends of a sub-trajectory that is corrected. `centre` is the object's in the
// world of `before`.
[[nodiscard]] double MovedApart_m(const Trajectory& before,
                                  const Trajectory& after,
                                  const MapObject& object,
                                  const Eigen::Vector3d& centre);

void MoveObjects(const Trajectory& before, const Trajectory& after, ObjectMap& map);

}  // namespace deepslam::modelling
