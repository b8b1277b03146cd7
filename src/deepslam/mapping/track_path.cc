#include "deepslam/mapping/track_path.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "deepslam/core/angles.h"
#include "deepslam/mapping/feature_starts.h"
#include "deepslam/mapping/keyframe_pyramids.h"
#include "deepslam/mapping/recorded_edges.h"
#include "deepslam/mapping/refine_path.h"

namespace deepslam::mapping {
namespace {

std::vector<Pose3> PosesOf(const std::vector<TrackedFrame>& frames) {
  std::vector<Pose3> poses;
  poses.reserve(frames.size());
  std::ranges::transform(frames, std::back_inserter(poses), &TrackedFrame::world_from_camera);
  return poses;
}

bool HasSome(const FrameSource& frames, const tracking::RecordedPoses& recorded) {
  for (int k = 0; k < frames.num_frames(); ++k)
    if (recorded(FrameIdx{k})) return true;
  return false;
}

void AddRecordedEdges(const tracking::RecordedPoses& recorded,
                      const tracking::OdometryOptions& options,
                      Odometry& tracked) {
  const RecordedNoise fallback{options.capture_translation_m,
                               options.capture_rotation_deg * kRadPerDeg};
  const RecordedNoise noise = EstimateRecordedNoise(tracked, recorded, fallback);
  std::ranges::move(RecordedEdges(tracked, recorded, noise), std::back_inserter(tracked.edges));
}

}  // namespace

Result<TrackedPath> TrackPath(const FrameSource& frames,
                              const tracking::OdometryOptions& options,
                              const loop::CovisibleOptions& covisible,
                              const EdgeStoreFactory& new_store,
                              Progress& progress,
                              RecordedPath recorded_path) {
  const bool as_prior = recorded_path == RecordedPath::kAsPrior;
  const tracking::RecordedPoses recorded =
      as_prior ? tracking::RecordedPosesOf(frames) : tracking::RecordedPoses();
  if (as_prior && !HasSome(frames, recorded)) {
    return InvalidInput(
        "the capture has no poses that tracking could start from (--poses prior); use --poses "
        "track");
  }
  const RefinementOptions refinement{
      covisible, options.alignment, options.num_relocalisation_keyframes, as_prior};
  KeyframePyramids pyramids = PyramidsToRefine(frames, refinement);
  // What tracking has read of keyframes is not read again.
  const auto take = [&](tracking::ReadKeyframe keyframe) {
    pyramids.Take(keyframe.frame, std::move(keyframe.pyramid));
    frames.GiveBack({keyframe.frame, 0, {}, std::move(keyframe.depth_m)});
  };
  // The keyframes that tracking looks back at, and the frames that it asks about.
  FeaturePlaces features(frames,
                         static_cast<std::size_t>(options.num_relocalisation_keyframes) + 4);
  tracking::OtherPlaces others{recorded, {}};
  if (options.alignment.photometric)
    others.features = [&](FrameIdx reference, FrameIdx frame) {
      return features.Find(reference, frame);
    };
  Result<Odometry> tracked = tracking::EstimateOdometry(frames, options, progress, take, others);
  if (!tracked.ok()) return tracked.error();
  std::vector<Pose3> as_tracked = PosesOf(tracked->frames);
  if (as_prior) AddRecordedEdges(recorded, options, *tracked);
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
