// The map: objects with class, shape, pose and confidence; and why each shape won.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam {

// What one view says about one placed candidate; counts of pixels and points, so that views can be
// pooled.
struct ViewAgreement {
  DetectionId view;
  FrameIdx frame;
  int num_points = 0;    // object points scored
  double surface = 0;    // mean agreement of the object's points with the model's surface, [0, 1]
  int num_seen = 0;      // rendered model pixels that the depth confirms or contradicts
  double coverage = 0;   // share of those confirmed
  double violation = 0;  // share of those where the ray goes on behind the model
  double reached = 0;    // share of the object's points not far off the model; not stored
};

// Agreement of one candidate with all depth of its object.
struct CandidateScore {
  CandidateId candidate;
  double score = 0;           // [0, 1], what decides
  double surface_share = 0;   // the object's depth points within tolerance of the model
  double coverage_share = 0;  // model surface that should be seen and is
  double free_violation = 0;  // rays that pass through solid model before their measured depth
  int num_views = 0;          // views registered
  double seen_share = 0;      // of the whole model's surface, what some view confirmed
  double reached_share = 1;   // object's depth points that are not far off the model's surface
  double front_blocked = 0;   // [0, 1], by the walls that it stands at (sides_at_walls.h)
  std::string note;           // why it could not be scored, or what was unsure
  std::vector<ViewAgreement> views;  // in the order of the object's views
};

// A step of the paper's greedy replacement as views arrive.
struct Replacement {
  FrameIdx frame;         // after the view of this frame
  CandidateId candidate;  // this one was the best so far
  double score = 0;
};

struct MapObject {
  ObjectId id;
  std::string class_name;
  std::map<std::string, double> class_votes;  // of its track
  CandidateId chosen;
  CandidateSource source = CandidateSource::kRetrieval;
  std::string model;  // key of the chosen shape
  std::string library_id;
  std::string credit;
  double scale_m = 1;                   // metres per object unit
  Pose3 world_from_object;              // metric object frame; see voxel_grid.h for its axes
  double confidence = 0;                // [0, 1]
  std::string note;                     // doubts in plain words; empty = none
  std::vector<ViewRegistration> views;  // of the chosen candidate
  std::vector<CandidateScore> scores;   // every candidate, best first
  std::vector<Replacement> history;     // greedy, in order of arrival
  std::vector<ObjectId> merged;         // ids of objects that loops found to be this one
};

// "chair_03": class and id; ids are unique over the map.
[[nodiscard]] std::string ObjectName(const MapObject& object);

struct ObjectMap {
  std::vector<MapObject> objects;    // ascending id
  std::vector<std::string> dropped;  // objects that got no place in the map, with the reason
};

}  // namespace deepslam
