#include "deepslam/mapping/track_path.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "deepslam/mapping/keyframe_pyramids.h"
#include "deepslam/mapping/refine_path.h"

namespace deepslam::mapping {
namespace {

std::vector<Pose3> PosesOf(const std::vector<TrackedFrame>& frames) {
  std::vector<Pose3> poses;
  poses.reserve(frames.size());
  std::ranges::transform(frames, std::back_inserter(poses), &TrackedFrame::world_from_camera);
  return poses;
}

}  // namespace

Result<TrackedPath> TrackPath(const FrameSource& frames,
                              const tracking::OdometryOptions& options,
                              const loop::CovisibleOptions& covisible,
                              const EdgeStoreFactory& new_store,
                              Progress& progress) {
  const RefinementOptions refinement{
      covisible, options.alignment, options.num_relocalisation_keyframes};
  KeyframePyramids pyramids = PyramidsToRefine(frames, refinement);
  // What tracking has read of keyframes is not read again.
  const auto take = [&](tracking::ReadKeyframe keyframe) {
    pyramids.Take(keyframe.frame, std::move(keyframe.pyramid));
    frames.GiveBack({keyframe.frame, 0, {}, std::move(keyframe.depth_m)});
  };
  Result<Odometry> tracked = tracking::EstimateOdometry(frames, options, progress, take);
  if (!tracked.ok()) return tracked.error();
  std::vector<Pose3> as_tracked = PosesOf(tracked->frames);
  Result<Odometry> refined =
      RefinePath(std::move(tracked).value(), std::move(pyramids), refinement, new_store, progress);
  if (!refined.ok()) return refined.error();
  return TrackedPath{std::move(refined).value(), std::move(as_tracked)};
}

Result<TrackedPath> TakePathOfCapture(const FrameSource& frames,
                                      const tracking::OdometryOptions& options,
                                      Progress& progress) {
  Result<Odometry> odometry = tracking::OdometryFromCapturePoses(frames, options, progress);
  if (!odometry.ok()) return odometry.error();
  std::vector<Pose3> poses = PosesOf(odometry->frames);
  return TrackedPath{std::move(odometry).value(), std::move(poses)};
}

}  // namespace deepslam::mapping
