// What loop detection found: which objects are one, and what ties old and new keyframes together.
#pragma once

#include <string>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam {

struct ObjectMerge {
  ObjectId kept;
  ObjectId merged;
};

// A constellation of at least two objects seen again.
struct Constellation {
  std::vector<ObjectMerge> pairs;
  Pose3 old_world_from_new_world;  // correction that brings the new objects onto the old ones
  double position_error_m = 0;     // rms over the pairs after the correction
  bool accepted = false;
  std::string reason;  // the geometric verification's verdict
};

// An observation of an object that association had re-identified, where what the observations
// measured stands apart: looked for like an object of its own. The first one has the object's own
// id.
struct SplitTracklet {
  ObjectId tracklet;
  ObjectId object;
  FrameIdx first;
  FrameIdx last;
};

// Two keyframes that show one place, found by what they look like.
struct AppearanceLoop {
  FrameIdx old_keyframe;
  FrameIdx new_keyframe;
  Pose3 old_from_new;    // camera to camera
  int num_inliers = 0;   // corners that agree with it
  int num_support = 0;   // other keyframes that say the same
  double agreement = 0;  // share of the common depth; 0 where none was compared
  bool accepted = false;
  std::string reason;  // the verdict
};

struct Loops {
  std::vector<Constellation> constellations;  // accepted and rejected ones
  std::vector<ObjectMerge> merges;            // accepted, each object merged at most once
  std::vector<RelativePose> edges;            // keyframe to keyframe, verified, of both kinds
  std::vector<AppearanceLoop> appearance;     // accepted and rejected ones
  std::vector<SplitTracklet> tracklets;       // ids that pairs and merges may name beside objects'
};

}  // namespace deepslam
