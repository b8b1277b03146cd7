// An object while the matching goes on: its detections so far and all their points.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/associate/point_cloud.h"
#include "deepslam/core/ids.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/object_track.h"

namespace deepslam::associate {

// A segment on its way through the matching.
struct Observation {
  const Segment* segment = nullptr;
  PointCloud cloud_world{{}};
  ObjectId object;  // invalid: none yet
};

struct ObjectHypothesis {
  ObjectId id;
  std::string class_name;            // by the members so far
  std::vector<int> observations;     // indices, ascending frames
  std::vector<TrackMember> members;  // one per observation
  std::string reason;
  std::vector<Eigen::Vector3f> points_world;  // of all members, thinned
  PointCloud cloud_world{{}};

  [[nodiscard]] bool IsSeenIn(FrameIdx frame) const;
  [[nodiscard]] double MeanScore(const std::vector<Observation>& all) const;
};

// Adds a detection; points closer than `cell_m` to known ones are not kept.
void AddMember(ObjectHypothesis& object,
               std::vector<Observation>& all,
               int observation,
               TrackMember member,
               double cell_m);

// Class of most members, weighted by score; what clusters guess by size counts a tenth. Of equal
// ones the first by name.
[[nodiscard]] std::string MajorityClass(const ObjectHypothesis& object,
                                        const std::vector<Observation>& all);

}  // namespace deepslam::associate
