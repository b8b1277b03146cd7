// Whether the poses that came with a capture fit its depth, and if not, which other way of writing
// poses would: points of one frame, moved by the poses into another, lie on what that one measured.
//
// Poses written by another convention are as smooth as right ones. What they say of two frames that
// are some way apart leaves the surfaces apart.
#pragma once

#include <span>
#include <string>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::dataset {

// Two frames of one camera that saw partly the same.
struct PosedPair {
  const DepthImage* a_m = nullptr;  // m, 0 invalid; of the camera's size; outlive this
  const DepthImage* b_m = nullptr;
  Pose3 world_from_a;  // as they were read
  Pose3 world_from_b;
};

struct PoseFit {
  int num_pairs = 0;         // that tell something: under some reading they fit
  double share = 0;          // of points that lie on the other frame's depth by the poses as read
  double best_share = 0;     // by the reading below
  double best_worth = 0;     // the same, less by what that reading changes
  std::string best_reading;  // in words; empty: as read

  // Another reading fits, and clearly better.
  [[nodiscard]] bool contradicts() const;
};

[[nodiscard]] PoseFit FitPoses(const PinholeCamera& camera, std::span<const PosedPair> pairs);

}  // namespace deepslam::dataset
