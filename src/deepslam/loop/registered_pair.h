// What the dense registration of two keyframes has to fulfil before it becomes an edge: common to
// loops (appearance.h), neighbours (neighbours.h) and covisible pairs (covisible.h). Numbers that
// are not finite fulfil nothing.
#pragma once

#include <string>

#include "deepslam/loop/appearance.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::loop {

struct RegistrationBounds {
  double min_agreement = 0;
  double min_correlation = 0;
  double max_move_m = 0;  // of the registered pose from the proposed one
  double max_turn_deg = 0;
};

// Why the registration does not bear the proposed pose out; empty where it does.
[[nodiscard]] std::string Verdict(const KeyframeRegistration& registration,
                                  const Pose3& proposed_old_from_new,
                                  const RegistrationBounds& bounds);

[[nodiscard]] bool Within(const Pose3& pose, double max_m, double max_deg);

// The solved poses of both keyframes are as measured.
[[nodiscard]] bool Agrees(const Trajectory& solved,
                          FrameIdx i,
                          FrameIdx j,
                          const Pose3& i_from_j,
                          double max_m,
                          double max_deg);

}  // namespace deepslam::loop
