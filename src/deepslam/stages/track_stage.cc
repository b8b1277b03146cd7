// track: camera poses and keyframes.
#include <algorithm>

#include <fmt/format.h>

#include "deepslam/artifact/pose_graph_g2o.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/odometry/odometry.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/refine_path.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

using pipeline::StageContext;
using pipeline::StageSummary;

namespace {

// Tracked, and refined by keyframes that see the same; how many edges these are.
struct TrackedPath {
  Odometry odometry;
  std::vector<artifact::StampedPose> as_tracked;
  int num_covisible = 0;
};

// What tracking has read of keyframes is not read again.
Result<TrackedPath> TrackAll(const RunInputs& inputs, Progress& progress) {
  const FrameSource& frames = *inputs.capture->frames;
  KeyframePyramids pyramids = PyramidsToRefine(inputs);
  const auto take = [&](odometry::ReadKeyframe keyframe) {
    pyramids.Take(keyframe.frame, std::move(keyframe.pyramid));
    frames.GiveBack({keyframe.frame, 0, {}, std::move(keyframe.depth_m)});
  };
  Result<Odometry> odometry =
      odometry::EstimateOdometry(frames, inputs.config.track, progress, take);
  if (!odometry.ok()) return odometry.error();
  TrackedPath path{std::move(odometry).value(), {}, 0};
  path.as_tracked = artifact::StampedPoses(path.odometry.frames);
  const Result<int> refined = RefinePath(inputs, std::move(pyramids), progress, path.odometry);
  if (!refined.ok()) return refined.error();
  path.num_covisible = *refined;
  return path;
}

Result<TrackedPath> TakePosesOfCapture(const RunInputs& inputs, Progress& progress) {
  Result<Odometry> odometry =
      odometry::OdometryFromCapturePoses(*inputs.capture->frames, inputs.config.track, progress);
  if (!odometry.ok()) return odometry.error();
  TrackedPath path{std::move(odometry).value(), {}, 0};
  path.as_tracked = artifact::StampedPoses(path.odometry.frames);
  return path;
}

}  // namespace

Result<StageSummary> RunTrack(StageContext& context, const RunInputs& inputs) {
  const bool capture_poses = inputs.config.track_stage.poses == "capture";
  const Result<TrackedPath> path = capture_poses ? TakePosesOfCapture(inputs, context.progress())
                                                 : TrackAll(inputs, context.progress());
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
              odometry->frames, odometry->keyframes, odometry->edges, "frames.json");
        }}});
  if (!written.ok()) return written.error();
  const Status edges = context.Write("odometry.g2o", [&](const artifact::TextSink& sink) {
    return artifact::EncodeG2o(
        odometry->frames, odometry->keyframes, odometry->edges, "odometry.g2o", sink);
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
  return StageSummary{
      fmt::format(
          "{} frames, {} lost, {} unreadable, {} weakly constrained; {} keyframes, {} edges, {} of "
          "them between keyframes that see the same",
          total,
          lost,
          unreadable,
          degenerate,
          odometry->keyframes.size(),
          odometry->edges.size(),
          path->num_covisible),
      {{"num_frames", static_cast<double>(total)},
       {"num_lost", static_cast<double>(lost)},
       {"num_unreadable", static_cast<double>(unreadable)},
       {"num_degenerate", static_cast<double>(degenerate)},
       {"num_keyframes", static_cast<double>(odometry->keyframes.size())},
       {"num_covisible", static_cast<double>(path->num_covisible)}}};
}

}  // namespace deepslam::stages
