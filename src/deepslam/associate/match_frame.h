// Matches the detections of one frame with objects known before it.
#pragma once

#include <span>
#include <vector>

#include "deepslam/associate/associate.h"
#include "deepslam/associate/object_hypothesis.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::associate {

struct Match {
  int observation = -1;
  ObjectId object;
  int num_votes = 0;
  double dissimilarity_m = 0;
};

// Votes of the observations of previous frames (`voters`: one list of observation indices per
// frame). Each object gets at most one of `current`, each of `current` at most one object.
[[nodiscard]] std::vector<Match> MatchByVotes(std::span<const int> current,
                                              std::span<const std::vector<int>> voters,
                                              const std::vector<Observation>& all,
                                              const PinholeCamera& camera,
                                              const Pose3& camera_from_world);

// The rest by all points of the objects that have no detection in this frame yet, best first.
[[nodiscard]] std::vector<Match> MatchByModels(std::span<const int> unmatched,
                                               std::span<const ObjectHypothesis> objects,
                                               const std::vector<Observation>& all);

}  // namespace deepslam::associate
