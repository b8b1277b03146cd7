// Steps of a path that its camera does not make: a wrong alignment, or a cut in the capture.
//
// What is a jump depends on what the capture's camera does. A hand keeps its pace; a recorder of
// one frame per key press moves by a quarter of a metre or turns by ten degrees, never both. So a
// step is held against two sets of the capture's other steps: all of them, and those that turned
// about as much (of a turn: those that moved as far).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "deepslam/scene/trajectory.h"

namespace deepslam::report {

struct PathJump {
  std::size_t to_frame = 0;
  double length_m = 0;
  double angle_rad = 0;
  bool is_turn = false;  // it is the turn that is unlike the others, not the distance
};

// In the order of the frames. Only steps between neighbours that were both aligned are looked at,
// by their speeds, so that frames that are left out make none.
[[nodiscard]] std::vector<PathJump> FindPathJumps(std::span<const TrackedFrame> frames);

}  // namespace deepslam::report
