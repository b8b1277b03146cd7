// track: camera poses and keyframes.
#include <algorithm>

#include <fmt/format.h>

#include "deepslam/artifact/pose_graph_g2o.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/refine_path.h"
#include "deepslam/stages/stage_inputs.h"
#include "deepslam/tracking/odometry.h"

namespace deepslam::stages {

using pipeline::StageContext;
using pipeline::StageSummary;

namespace {

// Tracked, and refined by keyframes that see the same.
struct TrackedPath {
  Odometry odometry;
  std::vector<artifact::StampedPose> as_tracked;
};

// What tracking has read of keyframes is not read again.
Result<TrackedPath> TrackAll(const StageContext& context, const RunInputs& inputs) {
  const FrameSource& frames = *inputs.capture->frames;
  KeyframePyramids pyramids = PyramidsToRefine(inputs);
  const auto take = [&](tracking::ReadKeyframe keyframe) {
    pyramids.Take(keyframe.frame, std::move(keyframe.pyramid));
    frames.GiveBack({keyframe.frame, 0, {}, std::move(keyframe.depth_m)});
  };
  Result<Odometry> odometry =
      tracking::EstimateOdometry(frames, inputs.config.track, context.progress(), take);
  if (!odometry.ok()) return odometry.error();
  TrackedPath path{std::move(odometry).value(), {}};
  path.as_tracked = artifact::StampedPoses(path.odometry.frames);
  const Status refined = RefinePath(context, inputs, std::move(pyramids), path.odometry);
  if (!refined.ok()) return refined.error();
  return path;
}

Result<TrackedPath> TakePosesOfCapture(const RunInputs& inputs, Progress& progress) {
  Result<Odometry> odometry =
      tracking::OdometryFromCapturePoses(*inputs.capture->frames, inputs.config.track, progress);
  if (!odometry.ok()) return odometry.error();
  TrackedPath path{std::move(odometry).value(), {}};
  path.as_tracked = artifact::StampedPoses(path.odometry.frames);
  return path;
}

}  // namespace

Result<StageSummary> RunTrack(StageContext& context, const RunInputs& inputs) {
  const bool capture_poses = inputs.config.track_stage.poses == "capture";
  const Result<TrackedPath> path =
      capture_poses ? TakePosesOfCapture(inputs, context.progress()) : TrackAll(context, inputs);
  if (!path.ok()) return path.error();
  const Odometry* const odometry = &path->odometry;
  const auto trajectory = artifact::StampedPoses(odometry->frames);
  const auto keyframes = artifact::KeyframePoses(odometry->frames, odometry->keyframes);
  const Status written = WriteFiles(
      context,
      {{"trajectory.tum", [&] { return artifact::EncodeTum(trajectory, "trajectory.tum"); }},
       {"keyframes.tum", [&] { return artifact::EncodeTum(keyframes, "keyframes.tum"); }},
       {"as_tracked.tum", [&] { return artifact::EncodeTum(path->as_tracked, "as_tracked.tum"); }},
       {"frames.json", [&] {
          return artifact::EncodeFrames(
              odometry->frames, odometry->keyframes, JoinsOf(*odometry), "frames.json");
        }}});
  if (!written.ok()) return written.error();
  const Status edges = context.Write("odometry.g2o", [&](const TextSink& sink) {
    return artifact::EncodeG2o(*odometry, "odometry.g2o", sink);
  });
  if (!edges.ok()) return edges.error();
  const auto count = [&](TrackingStatus status) {
    return std::count_if(odometry->frames.begin(),
                         odometry->frames.end(),
                         [&](const TrackedFrame& frame) { return frame.status == status; });
  };
  const auto lost = count(TrackingStatus::kLost);
  const auto unreadable = count(TrackingStatus::kUnreadable);
  const auto degenerate = count(TrackingStatus::kDegenerate);
  const std::size_t total = odometry->frames.size();
  const std::size_t num_covisible = odometry->num_edges() - odometry->edges.size();
  return StageSummary{
      fmt::format(
          "{} frames, {} lost, {} unreadable, {} weakly constrained; {} keyframes, {} edges, {} of "
          "them between keyframes that see the same",
          total,
          lost,
          unreadable,
          degenerate,
          odometry->keyframes.size(),
          odometry->num_edges(),
          num_covisible),
      {{"num_frames", static_cast<double>(total)},
       {"num_lost", static_cast<double>(lost)},
       {"num_unreadable", static_cast<double>(unreadable)},
       {"num_degenerate", static_cast<double>(degenerate)},
       {"num_keyframes", static_cast<double>(odometry->keyframes.size())},
       {"num_covisible", static_cast<double>(num_covisible)}}};
}

}  // namespace deepslam::stages
