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

Result<StageSummary> RunTrack(StageContext& context, const RunInputs& inputs) {
  const FrameSource& frames = *inputs.capture->frames;
  const bool capture_poses = inputs.config.track_stage.poses == "capture";
  Result<Odometry> odometry =
      capture_poses
          ? odometry::OdometryFromCapturePoses(frames, inputs.config.track, context.progress())
          : odometry::EstimateOdometry(frames, inputs.config.track, context.progress());
  if (!odometry.ok()) return odometry.error();
  const auto as_tracked = artifact::StampedPoses(odometry->frames);
  int num_covisible = 0;
  if (!capture_poses) {
    const Result<int> refined = RefinePath(inputs, context.progress(), *odometry);
    if (!refined.ok()) return refined.error();
    num_covisible = *refined;
  }
  const auto trajectory = artifact::StampedPoses(odometry->frames);
  const auto keyframes = artifact::KeyframePoses(odometry->frames, odometry->keyframes);
  const std::vector<std::pair<std::string_view, Result<std::string>>> files = {
      {"trajectory.tum", artifact::EncodeTum(trajectory, "trajectory.tum")},
      {"keyframes.tum", artifact::EncodeTum(keyframes, "keyframes.tum")},
      {"as_tracked.tum", artifact::EncodeTum(as_tracked, "as_tracked.tum")},
      {"odometry.g2o",
       artifact::EncodeG2o(odometry->frames, odometry->keyframes, odometry->edges, "odometry.g2o")},
      {"frames.json",
       artifact::EncodeFrames(
           odometry->frames, odometry->keyframes, odometry->edges, "frames.json")}};
  for (const auto& [file, text] : files) {
    if (Status status = WriteEncoded(context, file, text); !status.ok()) return status.error();
  }
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
          num_covisible),
      {{"num_frames", static_cast<double>(total)},
       {"num_lost", static_cast<double>(lost)},
       {"num_unreadable", static_cast<double>(unreadable)},
       {"num_degenerate", static_cast<double>(degenerate)},
       {"num_keyframes", static_cast<double>(odometry->keyframes.size())},
       {"num_covisible", static_cast<double>(num_covisible)}}};
}

}  // namespace deepslam::stages
