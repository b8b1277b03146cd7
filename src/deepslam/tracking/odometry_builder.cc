#include "deepslam/tracking/odometry_builder.h"

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "deepslam/core/angles.h"
#include "deepslam/tracking/pose_interpolation.h"

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;

TrackingStatus StatusOf(bool degenerate) {
  return degenerate ? TrackingStatus::kDegenerate : TrackingStatus::kTracked;
}

}  // namespace

Matrix6d DiagonalInformation(double sigma_m, double sigma_deg) {
  Vector6d diagonal;
  diagonal.head<3>().setConstant(1 / (sigma_m * sigma_m));
  diagonal.tail<3>().setConstant(1 / std::pow(sigma_deg * kRadPerDeg, 2));
  return diagonal.asDiagonal();
}

OdometryBuilder::OdometryBuilder(const OdometryOptions& options)
    : uncertain_(DiagonalInformation(options.lost_translation_m, options.lost_rotation_deg)) {}

void OdometryBuilder::AddFirst(const PosedFrame& frame) {
  const TrackingStatus status = StatusOf(frame.pyramid->one_depth);
  odometry_.frames.push_back({frame.frame, frame.time_s, Pose3{}, status, frame.frame, 0, 1});
}

void OdometryBuilder::AddAligned(const PosedFrame& frame,
                                 FrameIdx keyframe,
                                 const FrameAlignment& alignment) {
  odometry_.frames.push_back({frame.frame,
                              frame.time_s,
                              frame.world_from_camera,
                              StatusOf(alignment.degenerate || frame.pyramid->one_depth),
                              keyframe,
                              alignment.rmse_m,
                              alignment.fitness});
}

void OdometryBuilder::AddUnaligned(const PosedFrame& frame,
                                   FrameIdx keyframe,
                                   TrackingStatus status) {
  odometry_.frames.push_back(
      {frame.frame, frame.time_s, frame.world_from_camera, status, keyframe, 0, 0});
}

void OdometryBuilder::Promote(const PosedFrame& keyframe) {
  at(keyframe.frame).keyframe = keyframe.frame;
  at(keyframe.frame).world_from_camera = keyframe.world_from_camera;
}

void OdometryBuilder::AddEdge(const PosedFrame& i,
                              const PosedFrame& j,
                              const FrameAlignment& found) {
  odometry_.edges.push_back({i.frame, j.frame, found.i_from_j, found.information, false});
}

void OdometryBuilder::AddUncertainEdge(const PosedFrame& i, const PosedFrame& j) {
  const Pose3 i_from_j = i.world_from_camera.Inverse() * j.world_from_camera;
  odometry_.edges.push_back({i.frame, j.frame, i_from_j, uncertain_, true});
}

void OdometryBuilder::Move(std::size_t frame, const Pose3& motion) {
  TrackedFrame& moved = odometry_.frames[frame];
  moved.world_from_camera = motion * moved.world_from_camera;
}

void OdometryBuilder::GiveUp(FrameIdx first, FrameIdx end, FrameIdx keyframe) {
  for (int k = first.value; k < end.value; ++k) {
    TrackedFrame& frame = at(FrameIdx{k});
    if (frame.status != TrackingStatus::kUnreadable) frame.status = TrackingStatus::kLost;
    frame.keyframe = keyframe;
  }
  std::erase_if(odometry_.keyframes, [&](FrameIdx given_up) { return given_up >= first; });
  std::erase_if(odometry_.edges,
                [&](const RelativePose& edge) { return edge.i >= first || edge.j >= first; });
}

void OdometryBuilder::GiveUpAll() {
  for (TrackedFrame& frame : odometry_.frames) {
    if (frame.status == TrackingStatus::kUnreadable) continue;
    frame = {frame.frame, frame.time_s, Pose3{}, TrackingStatus::kLost, FrameIdx{}, 0, 0};
  }
  odometry_.keyframes.clear();
  odometry_.edges.clear();
}

Odometry OdometryBuilder::Finish(std::span<const double> times_s) && {
  if (odometry_.keyframes.empty()) return std::move(odometry_);
  std::vector<std::optional<Pose3>> poses;
  for (TrackedFrame& frame : odometry_.frames) {
    if (!frame.keyframe.valid()) frame.keyframe = odometry_.keyframes.front();
    const bool is_placed = IsAligned(frame) || frame.keyframe == frame.frame;
    poses.push_back(is_placed ? std::optional(frame.world_from_camera) : std::nullopt);
  }
  const std::vector<Pose3> filled = InterpolateMissing(poses, times_s);
  for (std::size_t k = 0; k < filled.size(); ++k) odometry_.frames[k].world_from_camera = filled[k];
  return std::move(odometry_);
}

}  // namespace deepslam::tracking
