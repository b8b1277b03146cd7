// An object while the matching goes on: its detections so far and all their points.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/associate/point_cloud.h"
#include "deepslam/core/ids.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_track.h"

namespace deepslam::associate {

// A segment on its way through the matching. Its points are kept as long as something may be held
// against them: what has found its object gives them up when it votes no more.
struct Observation {
  const Segment* segment = nullptr;
  std::vector<Eigen::Vector3f> points_world;
  PointCloud cloud_world{{}};  // of the same points; empty where they no longer vote
  ObjectId object;             // invalid: none yet
};

struct ObjectHypothesis {
  ObjectId id;
  std::string class_name;            // by the members so far
  std::vector<int> observations;     // indices, ascending frames
  std::vector<TrackMember> members;  // one per observation
  std::string reason;
  GrowingCloud points_world;  // of all members
  std::map<std::string, double> class_weights;

  [[nodiscard]] std::optional<std::size_t> MemberIn(FrameIdx frame) const;
  [[nodiscard]] double MeanScore(const std::vector<Observation>& all) const;
};

// Adds a detection, without its points. Its class is that of most members, weighted by score; what
// clusters guess by size counts a tenth; of equal ones the first by name.
void AddMember(ObjectHypothesis& object,
               std::vector<Observation>& all,
               int observation,
               TrackMember member);

// As tracks have them: of detections that are no clusters.
[[nodiscard]] std::map<std::string, double> ClassVotes(const ObjectHypothesis& object,
                                                       const std::vector<Observation>& all);

// Takes a detection out again.
void RemoveMember(ObjectHypothesis& object, std::vector<Observation>& all, std::size_t member);

}  // namespace deepslam::associate
