#include "deepslam/loop/registered_pair.h"

#include "deepslam/core/angles.h"

namespace deepslam::loop {

std::string Verdict(const KeyframeRegistration& registration,
                    const Pose3& proposed_old_from_new,
                    const RegistrationBounds& bounds) {
  if (!registration.ok) return "depth does not agree";
  if (!(registration.agreement >= bounds.min_agreement)) return "too little of the depth agrees";
  if (!(registration.intensity_correlation >= bounds.min_correlation))
    return "the images do not agree";
  const Pose3 moved = proposed_old_from_new.Inverse() * registration.old_from_new;
  if (!Within(moved, bounds.max_move_m, bounds.max_turn_deg)) return "depth and corners disagree";
  return {};
}

bool Within(const Pose3& pose, double max_m, double max_deg) {
  return pose.translation_m.norm() <= max_m && RotationAngle(pose.rotation) <= kRadPerDeg * max_deg;
}

bool Agrees(const Trajectory& solved,
            FrameIdx i,
            FrameIdx j,
            const Pose3& i_from_j,
            double max_m,
            double max_deg) {
  const Pose3 solved_i_from_j =
      solved.at(i).world_from_camera.Inverse() * solved.at(j).world_from_camera;
  return Within(i_from_j.Inverse() * solved_i_from_j, max_m, max_deg);
}

}  // namespace deepslam::loop
