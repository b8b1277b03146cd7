// How what was seen of a merged object moves onto the one that it is.
#pragma once

#include "deepslam/geometry/pose.h"
#include "deepslam/scene/loop.h"

namespace deepslam::loop {

// kept_from_merged in the world that the constellations were found in: along the accepted
// constellations' pairs, by as few steps as possible, with or against the time. The identity where
// no pairs lead from one to the other.
[[nodiscard]] Pose3 CorrectionOf(const ObjectMerge& merge, const Loops& loops);

}  // namespace deepslam::loop
