// track: camera poses and keyframes.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/pose_graph_g2o.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/mapping/join_sub_trajectories.h"
#include "deepslam/mapping/track_path.h"
#include "deepslam/stages/disk_edge_store.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

using pipeline::StageContext;
using pipeline::StageSummary;

namespace {

std::vector<artifact::StampedPose> AsTracked(const mapping::TrackedPath& path) {
  std::vector<artifact::StampedPose> poses = artifact::StampedPoses(path.odometry.frames);
  for (std::size_t k = 0; k < poses.size(); ++k)
    poses[k].world_from_camera = path.world_from_camera_as_tracked[k];
  return poses;
}

// Loops look for places by options of their own; a change there must not change what tracking is.
mapping::AppearanceClosing ClosingOptions(const Config& config) {
  return {{}, config.track.alignment, {}, !config.track.alignment.photometric};
}

// As tracked by this program; poses of the capture are not joined.
Result<mapping::TrackedPath> Tracked(StageContext& context, const RunInputs& inputs) {
  const FrameSource& frames = *inputs.capture->frames;
  const Config& config = inputs.config;
  Result<mapping::TrackedPath> path =
      mapping::TrackPath(frames,
                         config.track,
                         config.covisible,
                         DiskEdgeStores(context),
                         context.progress(),
                         config.track_stage.poses == "prior" ? mapping::RecordedPath::kAsPrior
                                                             : mapping::RecordedPath::kNone);
  if (!path.ok() || !config.joining.enabled) return path;
  Result<Odometry> joined = mapping::JoinSubTrajectories(
      frames, std::move(path->odometry), ClosingOptions(config), context.progress());
  if (!joined.ok()) return joined.error();
  path->odometry = std::move(joined).value();
  return path;
}

StageSummary Summarise(const Odometry& odometry) {
  const auto count = [&](TrackingStatus status) {
    return std::ranges::count(odometry.frames, status, &TrackedFrame::status);
  };
  const auto lost = count(TrackingStatus::kLost);
  const int num_parts = mapping::CountSubTrajectories(odometry);
  const auto unreadable = count(TrackingStatus::kUnreadable);
  const auto degenerate = count(TrackingStatus::kDegenerate);
  const std::size_t total = odometry.frames.size();
  const std::size_t num_covisible = odometry.num_edges() - odometry.edges.size();
  return StageSummary{
      fmt::format(
          "{} frames, {} lost, {} unreadable, {} weakly constrained; {} keyframes, {} edges, {} of "
          "them between keyframes that see the same{}",
          total,
          lost,
          unreadable,
          degenerate,
          odometry.keyframes.size(),
          odometry.num_edges(),
          num_covisible,
          num_parts > 1 ? fmt::format("; {} sub-trajectories that nothing ties together", num_parts)
                        : std::string()),
      {{"num_frames", static_cast<double>(total)},
       {"num_lost", static_cast<double>(lost)},
       {"num_unreadable", static_cast<double>(unreadable)},
       {"num_degenerate", static_cast<double>(degenerate)},
       {"num_keyframes", static_cast<double>(odometry.keyframes.size())},
       {"num_covisible", static_cast<double>(num_covisible)},
       {"num_sub_trajectories", static_cast<double>(num_parts)}}};
}

}  // namespace

Result<StageSummary> RunTrack(StageContext& context, const RunInputs& inputs) {
  const FrameSource& frames = *inputs.capture->frames;
  const Config& config = inputs.config;
  const bool capture_poses = config.track_stage.poses == "capture";
  const bool prior = config.track_stage.poses == "prior";
  if ((capture_poses || prior) && !inputs.capture->poses_fault.empty())
    return InvalidInput(inputs.capture->poses_fault + "; or use --poses track");
  const Result<mapping::TrackedPath> path =
      capture_poses ? mapping::TakePathOfCapture(frames, config.track, context.progress())
                    : Tracked(context, inputs);
  if (!path.ok()) return path.error();
  const Odometry& odometry = path->odometry;
  const Status written = WriteFiles(
      context,
      {{"trajectory.tum",
        [&] {
          return artifact::EncodeTum(artifact::StampedPoses(odometry.frames), "trajectory.tum");
        }},
       {"keyframes.tum",
        [&] {
          return artifact::EncodeTum(artifact::KeyframePoses(odometry.frames, odometry.keyframes),
                                     "keyframes.tum");
        }},
       {"as_tracked.tum", [&] { return artifact::EncodeTum(AsTracked(*path), "as_tracked.tum"); }},
       {"frames.json", [&] {
          return artifact::EncodeFrames(
              odometry.frames, odometry.keyframes, JoinsOf(odometry), "frames.json");
        }}});
  if (!written.ok()) return written.error();
  const Status edges = context.Write("odometry.g2o", [&](const TextSink& sink) {
    return artifact::EncodeG2o(odometry, "odometry.g2o", sink);
  });
  if (!edges.ok()) return edges.error();
  return Summarise(odometry);
}

}  // namespace deepslam::stages
