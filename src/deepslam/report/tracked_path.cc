#include "deepslam/report/tracked_path.h"

#include <cstddef>

namespace deepslam::report {

TrackedPath LayOntoMap(const Trajectory& tracked, const Ground& ground, const OptimizedMap& map) {
  TrackedPath path;
  const std::vector<TrackedFrame>& final_frames = map.frames;
  if (final_frames.empty() || tracked.frames.size() != final_frames.size()) return path;
  const Pose3 world_from_tracking =
      final_frames.front().world_from_camera * tracked.frames.front().world_from_camera.Inverse();
  for (const TrackedFrame& frame : tracked.frames)
    path.world_from_camera.push_back(world_from_tracking * frame.world_from_camera);
  if (!map.has_ground) return path;
  for (const GroundObservation& seen : ground.observations) {
    const auto at = static_cast<std::size_t>(seen.keyframe.value);
    if (at >= final_frames.size()) continue;
    path.heights.push_back({seen.keyframe,
                            seen.plane_camera.d_m,
                            path.world_from_camera[at].translation_m.z(),
                            final_frames[at].world_from_camera.translation_m.z()});
  }
  return path;
}

}  // namespace deepslam::report
