// The relative pose of two keyframes from matched corners with depth: mutual nearest descriptors
// that beat the second nearest (Lowe's ratio), three-point RANSAC on the points, least squares over
// those that agree (Umeyama 1991, without scale).
#pragma once

#include <optional>

#include "deepslam/geometry/pose.h"
#include "deepslam/loop/keyframe_features.h"

namespace deepslam::loop {

struct FeaturePose {
  Pose3 old_from_new;  // camera to camera
  int num_inliers = 0;
  // Largest number of the other matches that agree with one another pose: as many as the inliers
  // where a thing, or a pattern, stands twice.
  int num_rivals = 0;
  // Smaller principal deviation of the inliers' directions, seen by either camera, the lesser.
  double spread_rad = 0;
};

// Corners agree when their directions differ by less than 0.01 rad after the transform and their
// depths by less than 3 cm + 1.5 % of the squared depth. Nothing with fewer than `min_inliers` (at
// least 4) that agree. Deterministic.
[[nodiscard]] std::optional<FeaturePose> PoseFromFeatures(const KeyframeFeatures& old_features,
                                                          const KeyframeFeatures& new_features,
                                                          int min_inliers);
[[nodiscard]] std::optional<FeaturePose> PoseFromFeatures(const GradientFeatures& old_features,
                                                          const GradientFeatures& new_features,
                                                          int min_inliers);

}  // namespace deepslam::loop
