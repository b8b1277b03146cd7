// The graph of cameras and ground, and of objects where there are any, for what the path becomes.
#pragma once

#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/graph/object_graph.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::stages {

// Cameras, ground and objects as the graph has them with `edges` beside tracking's own and the
// views of `map`; in the tracking world (the first keyframe stays).
struct SolvedPath {
  std::vector<TrackedFrame> frames;
  Ground ground;
  std::vector<Pose3> world_from_object;  // in the map's order
};

[[nodiscard]] Result<SolvedPath> SolvePath(const Odometry& odometry,
                                           const Ground& ground,
                                           const std::vector<RelativePose>& edges,
                                           const graph::GraphOptions& options,
                                           const ObjectMap& map = {});

// Of a path whose edges join keyframes near each other in time, keyframes that are solved at a
// time.
struct Stretches {
  int num_keyframes = 600;
  int overlap = 120;  // below num_keyframes; at least the keyframes between the two of any edge
};

// The frames of a path without loops, in memory that does not grow with its length: stretch by
// stretch, each laid on the one before in the middle of what they share. Poses apart from a graph
// of the whole by what edges say that are half an overlap away. The first keyframe stays. Edges
// that are not held (more_edges) ascend by j.
[[nodiscard]] Result<std::vector<TrackedFrame>> SolveStretches(const Odometry& odometry,
                                                               const graph::GraphOptions& options,
                                                               const Stretches& stretches);

}  // namespace deepslam::stages
