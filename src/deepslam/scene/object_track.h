// Which detections are the same physical object, before any loop is closed.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/geometry/box.h"

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

// A place in a frame.
struct SeenIn {
  FrameIdx frame{-1};  // below 0: none
  Box2 box_px;
};

// What was seen and is no object of the map.
struct NotMapped {
  std::string what;  // a sentence, with the reason
  SeenIn best;       // where it shows best
};

struct Association {
  std::vector<ObjectTrack> tracks;    // ascending id
  std::vector<Rejection> rejections;  // detections that belong to no object
  // Of objects found in the surface of the capture alone.
  std::vector<NotMapped> not_mapped = {};
};

}  // namespace deepslam
