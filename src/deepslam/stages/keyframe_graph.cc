#include "deepslam/stages/keyframe_graph.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "deepslam/core/check.h"
#include "deepslam/scene/loop.h"

namespace deepslam::stages {
namespace {

// Keyframes from `begin` to before `end` and the edges among them; frames keep their numbers.
Odometry Stretch(const Odometry& odometry, std::ptrdiff_t begin, std::ptrdiff_t end) {
  Odometry stretch;
  stretch.frames = odometry.frames;
  stretch.keyframes.assign(odometry.keyframes.begin() + begin, odometry.keyframes.begin() + end);
  const auto inside = [&](FrameIdx keyframe) {
    return stretch.keyframes.front() <= keyframe && keyframe <= stretch.keyframes.back();
  };
  std::ranges::copy_if(odometry.edges,
                       std::back_inserter(stretch.edges),
                       [&](const RelativePose& edge) { return inside(edge.i) && inside(edge.j); });
  return stretch;
}

// Everything from `seam` on goes to where the solved frames lie about it.
void LayOn(FrameIdx seam,
           const std::vector<TrackedFrame>& solved,
           std::vector<TrackedFrame>& frames) {
  const auto first = static_cast<std::size_t>(seam.value);
  const Pose3 moved = frames[first].world_from_camera * solved[first].world_from_camera.Inverse();
  for (std::size_t k = first; k < frames.size(); ++k)
    frames[k].world_from_camera = moved * solved[k].world_from_camera;
}

}  // namespace

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

Result<std::vector<TrackedFrame>> SolveStretches(const Odometry& odometry,
                                                 const graph::GraphOptions& options,
                                                 const Stretches& stretches) {
  DEEPSLAM_CHECK(0 <= stretches.overlap && stretches.overlap < stretches.num_keyframes,
                 "stretches have to go on");
  const auto num_keyframes = static_cast<std::ptrdiff_t>(odometry.keyframes.size());
  if (num_keyframes <= stretches.num_keyframes) {
    Result<SolvedPath> whole = SolvePath(odometry, Ground{}, {}, options);
    if (!whole.ok()) return whole.error();
    return std::move(whole->frames);
  }
  std::vector<TrackedFrame> frames = odometry.frames;
  std::ptrdiff_t begin = 0;
  for (std::ptrdiff_t end = 0; end < num_keyframes; begin = end - stretches.overlap) {
    end = std::min<std::ptrdiff_t>(begin + stretches.num_keyframes, num_keyframes);
    const Result<SolvedPath> solved =
        SolvePath(Stretch(odometry, begin, end), Ground{}, {}, options);
    if (!solved.ok()) return solved.error();
    const std::ptrdiff_t seam = begin == 0 ? 0 : begin + stretches.overlap / 2;
    LayOn(odometry.keyframes[static_cast<std::size_t>(seam)], solved->frames, frames);
  }
  return frames;
}

}  // namespace deepslam::stages
