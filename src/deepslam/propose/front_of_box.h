// Which of the four sides of a measured box is its front.
#pragma once

#include <optional>
#include <span>

#include "deepslam/geometry/pose.h"
#include "deepslam/propose/level_box.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::propose {

struct FrontEvidence {
  std::span<const ObjectView> views;
  const Layout* layout = nullptr;  // none: nothing is known of walls
  // Of what was measured, where it has a high back: shape::QuarterTurnsFromHighBack.
  std::optional<int> turns_from_high_back;
};

// Quarter turns, counter-clockwise seen from above, that bring the front to +x of a grid along the
// box. The front of a thin thing is a wide side; a high back stands behind; of what is left
// furniture is wider than deep, turns its back to the wall it stands at, and its front to where it
// is seen from.
[[nodiscard]] int QuarterTurnsToFront(const LevelBox& box,
                                      const Pose3& level_from_world,
                                      const FrontEvidence& evidence);

}  // namespace deepslam::propose
