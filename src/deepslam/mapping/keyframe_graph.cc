#include "deepslam/mapping/keyframe_graph.h"

#include <cstddef>

#include "deepslam/scene/loop.h"

namespace deepslam::mapping {

Result<SolvedPath> SolvePath(const Odometry& odometry,
                             const Ground& ground,
                             const std::vector<RelativePose>& edges,
                             const graph::GraphOptions& options,
                             const ObjectMap& map) {
  Loops loops;
  loops.edges = edges;
  const Result<OptimizedMap> solved = graph::OptimizeGraph(odometry, ground, map, loops, options);
  if (!solved.ok()) return solved.error();
  const auto first = static_cast<std::size_t>(odometry.keyframes.front().value);
  const Pose3 tracking_from_level =
      odometry.frames[first].world_from_camera * solved->frames[first].world_from_camera.Inverse();
  SolvedPath path{odometry.frames, ground, {}};
  for (std::size_t k = 0; k < path.frames.size(); ++k) {
    path.frames[k].world_from_camera = tracking_from_level * solved->frames[k].world_from_camera;
  }
  if (solved->has_ground)
    path.ground.plane_world = Transformed(tracking_from_level, solved->ground_world);
  for (GroundApart& apart : path.ground.apart) {
    if (!apart.plane_world) continue;
    const auto own = static_cast<std::size_t>(apart.first.value);
    const Pose3 solved_from_tracked =
        path.frames[own].world_from_camera * odometry.frames[own].world_from_camera.Inverse();
    apart.plane_world = Transformed(solved_from_tracked, *apart.plane_world);
  }
  for (const MapObject& object : solved->map.objects)
    path.world_from_object.push_back(tracking_from_level * object.world_from_object);
  return path;
}

}  // namespace deepslam::mapping
