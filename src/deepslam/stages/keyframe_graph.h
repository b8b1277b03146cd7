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

}  // namespace deepslam::stages
