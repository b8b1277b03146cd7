#include "deepslam/overrides/apply_to_ground.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "deepslam/core/angles.h"

namespace deepslam::overrides {
namespace {

constexpr double kHintAngleRad = 10 * kRadPerDeg;  // a person's guess of upright
constexpr double kHintHeightM = 0.15;              // levels closer than this are one

}  // namespace

std::vector<std::string> ApplyToGround(const Overrides& overrides,
                                       const Trajectory& trajectory,
                                       Ground& ground) {
  if (!overrides.ground) return {};
  // The world is the first camera's, so the hint is a plane of the world as it stands.
  const Plane hint{overrides.ground->up_camera, overrides.ground->height_m};
  const auto agrees = [&](const Plane& plane_world) {
    const double cosine = std::clamp(plane_world.normal.dot(hint.normal), -1.0, 1.0);
    return std::acos(cosine) < kHintAngleRad && std::abs(plane_world.d_m - hint.d_m) < kHintHeightM;
  };
  // What was not registered to the first camera keeps its own ground.
  const std::size_t before = ground.observations.size();
  std::erase_if(ground.observations, [&](const GroundObservation& observation) {
    if (ApartAt(ground, observation.keyframe) != nullptr) return false;
    const Pose3& world_from_camera = trajectory.at(observation.keyframe).world_from_camera;
    return !agrees(Transformed(world_from_camera, observation.plane_camera));
  });
  const std::size_t removed = before - ground.observations.size();
  if (ground.plane_world && agrees(*ground.plane_world)) {
    return {fmt::format(
        "the ground found agrees with the hint; {} of {} observations left out", removed, before)};
  }
  ground.plane_world = hint;
  return {
      fmt::format("the hint is the ground, {:.2f} m below the first camera; {} of {} "
                  "observations left out",
                  hint.d_m,
                  removed,
                  before)};
}

}  // namespace deepslam::overrides
