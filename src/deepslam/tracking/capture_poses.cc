#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/tracking/keyframe_policy.h"
#include "deepslam/tracking/odometry.h"
#include "deepslam/tracking/odometry_builder.h"
#include "deepslam/tracking/pose_interpolation.h"

namespace deepslam::tracking {
namespace {

bool Usable(const std::optional<Pose3>& pose) {
  return pose && pose->translation_m.allFinite() && pose->rotation.coeffs().allFinite() &&
         std::abs(pose->rotation.norm() - 1) < 1e-3;
}

RelativePose Edge(const TrackedFrame& i, const TrackedFrame& j, const OdometryOptions& options) {
  return {i.frame,
          j.frame,
          i.world_from_camera.Inverse() * j.world_from_camera,
          DiagonalInformation(options.capture_translation_m, options.capture_rotation_deg),
          false};
}

void ChooseKeyframes(const OdometryOptions& options, Odometry& odometry) {
  std::optional<std::size_t> last;
  for (std::size_t k = 0; k < odometry.frames.size(); ++k) {
    TrackedFrame& frame = odometry.frames[k];
    const bool known = frame.status == TrackingStatus::kTracked;
    const TrackedFrame* keyframe = last ? &odometry.frames[*last] : nullptr;
    if (known && (keyframe == nullptr ||
                  IsFarFrom(keyframe->world_from_camera, frame.world_from_camera, options))) {
      if (keyframe != nullptr) odometry.edges.push_back(Edge(*keyframe, frame, options));
      odometry.keyframes.push_back(frame.frame);
      last = k;
    }
    if (last) frame.keyframe = odometry.frames[*last].frame;
  }
  for (TrackedFrame& frame : odometry.frames) {
    if (!frame.keyframe.valid()) frame.keyframe = odometry.keyframes.front();
  }
}

// Poses say nothing about the images: those that cannot be read are marked and named, as tracking
// does. Refuses captures of which most are bad.
Status MarkUnreadable(const FrameSource& frames, Progress& progress, Odometry& odometry) {
  std::vector<std::string> faults(odometry.frames.size());
  ParallelFor(faults.size(), [&](std::size_t k) {
    if (progress.StopRequested()) return;
    const Result<Frame> frame = frames.Read(odometry.frames[k].frame);
    if (!frame.ok()) faults[k] = frame.error().message;
  });
  if (progress.StopRequested()) return Interrupted();
  std::size_t num_bad = 0;
  std::string first;
  for (std::size_t k = 0; k < faults.size(); ++k) {
    if (faults[k].empty()) continue;
    if (num_bad++ == 0) first = faults[k];
    odometry.frames[k].status = TrackingStatus::kUnreadable;
    odometry.frames[k].inlier_share = 0;
    progress.Warn("frame " + std::to_string(k) + " skipped: " + faults[k]);
  }
  if (2 * num_bad <= faults.size()) return Ok();
  return InvalidInput(std::to_string(num_bad) + " of " + std::to_string(faults.size()) +
                      " frames could not be read; the first: " + first);
}

}  // namespace

RecordedPoses RecordedPosesOf(const FrameSource& frames) {
  return [&frames](FrameIdx frame) {
    const std::optional<Pose3> pose = frames.capture_world_from_camera(frame);
    return Usable(pose) ? pose : std::nullopt;
  };
}

Result<Odometry> OdometryFromCapturePoses(const FrameSource& frames,
                                          const OdometryOptions& options,
                                          Progress& progress) {
  const RecordedPoses recorded = RecordedPosesOf(frames);
  std::vector<std::optional<Pose3>> poses;
  std::vector<double> times_s;
  for (std::int32_t k = 0; k < frames.num_frames(); ++k) {
    poses.push_back(recorded(FrameIdx{k}));
    times_s.push_back(frames.time_s(FrameIdx{k}));
  }
  const auto first =
      std::find_if(poses.begin(), poses.end(), [](const auto& pose) { return pose.has_value(); });
  if (first == poses.end()) {
    return InvalidInput(
        "the capture has no poses (in TUM's layout: groundtruth.txt is missing or none of its "
        "times "
        "is near a frame); use --poses track");
  }
  const Pose3 world_from_capture = (*first)->Inverse();
  const std::vector<Pose3> filled = InterpolateMissing(poses, times_s);
  Odometry odometry;
  for (std::size_t k = 0; k < filled.size(); ++k) {
    TrackedFrame frame;
    frame.frame = FrameIdx{static_cast<std::int32_t>(k)};
    frame.time_s = times_s[k];
    frame.world_from_camera = world_from_capture * filled[k];
    frame.status = poses[k] ? TrackingStatus::kTracked : TrackingStatus::kLost;
    frame.inlier_share = poses[k] ? 1 : 0;
    odometry.frames.push_back(frame);
  }
  if (Status status = MarkUnreadable(frames, progress, odometry); !status.ok())
    return status.error();
  if (std::none_of(odometry.frames.begin(), odometry.frames.end(), [](const TrackedFrame& frame) {
        return frame.status == TrackingStatus::kTracked;
      })) {
    return InvalidInput("no frame that has a pose can be read; use --poses track");
  }
  ChooseKeyframes(options, odometry);
  progress.Report(odometry.frames.size(), odometry.frames.size());
  return odometry;
}

}  // namespace deepslam::tracking
