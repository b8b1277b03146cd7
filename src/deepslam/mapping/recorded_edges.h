// What whoever recorded a capture says of its path, as edges of the graph: weak ones beside those
// that were measured here, and all there is where nothing could be.
#pragma once

#include <vector>

#include "deepslam/scene/trajectory.h"
#include "deepslam/tracking/odometry.h"

namespace deepslam::mapping {

// One standard deviation of the recorder's motion from keyframe to keyframe.
struct RecordedNoise {
  double translation_m = 0;
  double rotation_rad = 0;
};

// Out of the keyframes that were aligned: how far their motion is from the recorder's. Both err, so
// it is an upper bound. That of `fallback` where too few tell.
[[nodiscard]] RecordedNoise EstimateRecordedNoise(const Odometry& tracked,
                                                  const tracking::RecordedPoses& recorded,
                                                  const RecordedNoise& fallback);

// Between keyframes that follow each other and that the recorder has poses of.
[[nodiscard]] std::vector<RelativePose> RecordedEdges(const Odometry& tracked,
                                                      const tracking::RecordedPoses& recorded,
                                                      const RecordedNoise& noise);

}  // namespace deepslam::mapping
