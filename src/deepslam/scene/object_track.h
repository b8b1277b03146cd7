// Which detections are the same physical object, before any loop is closed.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "deepslam/core/ids.h"

namespace deepslam {

// One detection's way into a track.
struct TrackMember {
  DetectionId detection;
  FrameIdx frame;
  int num_votes = 0;           // previous frames that voted for this object
  double dissimilarity_m = 0;  // mean closest-point error of the winning votes
  std::string how;             // "new", "vote", "model" (re-found by the projected model), "merge"
};

struct ObjectTrack {
  ObjectId id;
  std::string class_name;            // majority of member classes, weighted by detection score
  std::vector<TrackMember> members;  // ascending frames
  std::string reason;                // why this object was started
  // What detectors, files or persons call it: sums of the scores of its detections by class. What
  // clusters of depth guess by size is no vote.
  std::map<std::string, double> class_votes = {};

  // Somebody calls it by its class; else the class is a guess by size.
  [[nodiscard]] bool is_named() const { return class_votes.contains(class_name); }
};

struct Rejection {
  DetectionId detection;
  FrameIdx frame;
  std::string reason;  // "touches border", "ambiguous", "too few points" ...
};

struct Association {
  std::vector<ObjectTrack> tracks;    // ascending id
  std::vector<Rejection> rejections;  // detections that belong to no object
  // What was seen and is no object, a sentence for each with the reason; of objects found in the
  // surface of the capture alone.
  std::vector<std::string> not_mapped = {};
};

}  // namespace deepslam
