// What the report page shows of one capture: plain values, gathered by the stage that writes the
// page.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/core/image.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/optimized_map.h"

namespace deepslam::report {

// An encoded picture; `mime` is "image/jpeg" or "image/png".
struct Picture {
  std::string bytes;
  std::string mime = "image/jpeg";
  std::string caption;
};

// One row of an object's candidate table.
struct CandidateRow {
  std::string model;
  std::string source;
  double score = 0;
  double surface_share = 0;
  double coverage_share = 0;
  double free_violation = 0;
  int num_views = 0;
  bool chosen = false;
  std::string note;
  Picture thumbnail;        // the model by itself; no bytes = none
  bool is_partial = false;  // holds only what was measured
};

// An object of less confidence is more likely to stand elsewhere than where it is said to.
inline constexpr double kEvenOdds = 0.5;

struct ObjectRow {
  std::string name;  // "chair_03"
  std::string class_name;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // along object x (front), y (left), z (up)
  Pose3 world_from_object;                           // gravity-aligned world
  double bottom_above_ground_m = 0;
  double confidence = 0;
  int num_views = 0;
  std::string source;
  std::string credit;
  std::string note;
  Rgb8 colour;
  std::vector<CandidateRow> candidates;         // best first
  std::vector<Picture> pictures;                // crops with the model drawn in
  std::vector<Eigen::Vector3f> measured_world;  // some of the object's depth points, m
};

// A photograph and the same view of the map.
struct PicturePair {
  Picture photograph;
  Picture map;
};

// Height of the camera above the floor in one keyframe: read off the floor in that very frame, and
// as the trajectory has it before and after the graph. All m; differences are drift.
struct HeightCheck {
  FrameIdx frame;
  double measured_m = 0;
  double before_m = 0;
  double after_m = 0;
};

// Bytes of what a run leaves, each for the same room; 0 = not known.
struct ResultSizes {
  std::size_t map_json = 0;
  std::size_t objects_glb = 0;  // a scene of the objects alone, compressed as in scene.glb
  std::size_t scene_glb = 0;    // with the room, the floor and the path
  std::size_t fused_cloud =
      0;  // points of the fused surface at 1 cm, 15 bytes each, reckoned from its area
};

struct ReportContent {
  std::string title;  // the capture's name
  std::string tool_version;
  std::string capture_hash;
  std::string verdict;  // "good", "doubtful" or "bad"
  std::vector<std::string> verdict_reasons;
  std::vector<std::string> warnings;
  // What was seen and is no object, with the reason; `bytes` is empty where no frame may be shown.
  std::vector<Picture> not_mapped;
  std::vector<std::string> corrections;  // what a person overrode, one sentence each
  OptimizedMap map;     // trajectory, ground and energy; the objects are in `objects`
  Layout layout_world;  // the room itself
  Loops loops;          // places seen again
  std::vector<Pose3>
      tracked_world_from_camera;     // before the graph, aligned to the same world; may be empty
  std::vector<HeightCheck> heights;  // ascending frames; empty without a ground
  std::vector<ObjectRow> objects;
  std::string scene_glb;                // what the 3D view shows; empty = no 3D view
  std::vector<Picture> scene_pictures;  // the map rendered
  std::vector<PicturePair> photographs;
  std::vector<Picture> frame_pictures;  // frames with detections and segments drawn in
  int num_person_frames = 0;            // frames left out of all pictures: a person was seen
  bool looked_for_people = true;        // false: no detector looked at the frames
  std::vector<std::pair<std::string, std::string>> stage_summaries;  // stage, one line
  std::vector<std::pair<std::string, std::size_t>> file_bytes;       // result file, size
  ResultSizes sizes;
};

}  // namespace deepslam::report
