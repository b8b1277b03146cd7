// A frame in the tracker: prepared for alignment, and where it was placed.
#pragma once

#include <memory>
#include <optional>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/core/ids.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/tracking/free_space.h"

namespace deepslam::tracking {

struct PosedFrame {
  FrameIdx frame;
  double time_s = 0;   // of the capture
  double clock_s = 0;  // of MonotonicClock
  std::shared_ptr<const alignment::FramePyramid> pyramid;
  Pose3 world_from_camera;
  int sub_trajectory = 0;
  // World from camera by whoever recorded it, in a world of its own; nothing where it has none.
  std::optional<Pose3> recorded;

  [[nodiscard]] PlacedPyramid Placed() const { return {pyramid, world_from_camera}; }
};

}  // namespace deepslam::tracking
