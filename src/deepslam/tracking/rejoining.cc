#include "deepslam/tracking/rejoining.h"

#include <algorithm>
#include <vector>

#include "deepslam/tracking/free_space.h"
#include "deepslam/tracking/placement_acceptance.h"

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;

// As long as somebody takes to pass by.
constexpr double kPassingBy_s = 2;

// Whether keyframes of the frame's sub-trajectory, moved, violate no free space of the earlier one.
bool Belongs(const PathSoFar& path,
             const PosedFrame& frame,
             int earlier,
             const Pose3& motion,
             double max_violation) {
  std::vector<PlacedPyramid> moved = path.keyframes.PlacedOf(frame.sub_trajectory);
  for (PlacedPyramid& keyframe : moved)
    keyframe.world_from_camera = motion * keyframe.world_from_camera;
  return FreeSpaceViolation(path.keyframes.PlacedOf(earlier),
                            moved,
                            path.options.alignment.pyramid.noise) <= max_violation;
}

}  // namespace

std::optional<Rejoining> FindRejoining(const PathSoFar& path,
                                       const PosedFrame& frame,
                                       const SubTrajectories& sub_trajectories,
                                       const MonotonicClock& clock) {
  for (const PosedFrame& earlier : path.keyframes.all()) {
    if (earlier.sub_trajectory >= frame.sub_trajectory) continue;
    const Starts starts{{earlier.world_from_camera}, &earlier};
    FrameAlignment found = Place(path, earlier, path.previous, frame, starts);
    if (!IsConfident(found)) continue;
    found = alignment::Sharpened(found, *earlier.pyramid, *frame.pyramid, path.options.alignment);
    const Pose3 motion =
        earlier.world_from_camera * found.i_from_j * frame.world_from_camera.Inverse();
    const bool belongs =
        Belongs(path, frame, earlier.sub_trajectory, motion, MaxViolationFar(found));
    if (!belongs &&
        !IsPassingBy(frame, earlier.sub_trajectory, path.keyframes, sub_trajectories, clock))
      continue;
    return Rejoining{earlier, found, motion, !belongs};
  }
  return std::nullopt;
}

bool IsPassingBy(const PosedFrame& frame,
                 int earlier,
                 const KeyframeWindow& keyframes,
                 const SubTrajectories& sub_trajectories,
                 const MonotonicClock& clock) {
  const FrameIdx start = sub_trajectories.StartOf(frame.sub_trajectory);
  const double start_s = clock.TimeOf(start);
  const double lasts_s = frame.clock_s - start_s;
  const double lasted_s = start_s - clock.TimeOf(sub_trajectories.StartOf(earlier));
  return lasts_s < std::min(kPassingBy_s, lasted_s) &&
         std::ranges::all_of(keyframes.all(), [&](const PosedFrame& keyframe) {
           return (keyframe.frame >= start) == (keyframe.sub_trajectory == frame.sub_trajectory);
         });
}

}  // namespace deepslam::tracking
