// The graph of cameras and ground, and of objects where there are any, solved for the path: the
// optimizer (graph/object_graph.h) levels its world, a path stays in the tracking world.
#pragma once

#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/graph/object_graph.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::mapping {

// In the tracking world, in which the first keyframe stays where it is.
struct SolvedPath {
  std::vector<TrackedFrame> frames;
  Ground ground;
  std::vector<Pose3> world_from_object;  // in the map's order
};

// Cameras, ground and objects as the graph has them with `edges`, as loops, beside the odometry's
// own and with the views of `map`. There must be a keyframe. Errors are the optimizer's.
[[nodiscard]] Result<SolvedPath> SolvePath(const Odometry& odometry,
                                           const Ground& ground,
                                           const std::vector<RelativePose>& edges,
                                           const graph::GraphOptions& options,
                                           const ObjectMap& map = {});

}  // namespace deepslam::mapping
