// Which of the planes in a keyframe is the ground, where the plane propagated there has gathered
// drift since the ground was last seen.
//
// Over a step or two the plane nearest to the propagated one is the ground. After long parts
// without floor it may as well be a table top, so candidates come from all horizontal planes within
// reach, the lowest one that is large counts, and nothing may lie below it in the keyframes about.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/ground/ground_plane.h"
#include "deepslam/ground/level_search.h"

namespace deepslam::ground {

// How far the ground may lie from where it was propagated to.
struct Reach {
  double distance_m = 0;
  double turn_rad = 0;
};

// Three standard deviations of the propagated plane (information as GroundObservation), 30 cm and
// 12 deg at most: a table top 0.4 m above the floor stays out of reach while the drift is below 10
// cm, one of 0.74 m while it is below 44 cm; beyond that IsLowest has to tell.
[[nodiscard]] Reach ReachOf(const Eigen::Matrix3d& information);

// Beyond what the nearest plane is looked for in (kMaxShiftM, kMaxTurnRad).
[[nodiscard]] bool IsWide(const Reach& reach);

// The keyframe's planes that may be the ground propagated to `predicted_camera`.
[[nodiscard]] std::vector<Plane> PlanesWithin(std::span<const PlaneSighting> of_keyframe,
                                              const Plane& predicted_camera,
                                              const Reach& reach);

// The samples of the keyframes about hold next to nothing below the plane: a table top has floor
// beside it somewhere, the floor has nothing below it.
[[nodiscard]] bool IsLowest(const Plane& plane_world, std::span<const KeyframeSample> samples);

}  // namespace deepslam::ground
