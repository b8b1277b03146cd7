// Where a frame may be, by points that it and another frame show: found without any idea of the
// camera's motion.
#pragma once

#include <functional>
#include <optional>

#include "deepslam/core/ids.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::tracking {

struct FeatureStart {
  Pose3 reference_from_frame;
  int num_inliers = 0;  // points that agree with it
};

// Of a frame against a reference. Nothing where too few points agree with one pose. Takes a tenth
// of a second and more, so it is asked where nothing else places a frame.
using FeatureStarts =
    std::function<std::optional<FeatureStart>(FrameIdx reference, FrameIdx frame)>;

}  // namespace deepslam::tracking
