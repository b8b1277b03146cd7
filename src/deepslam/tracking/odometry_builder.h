// The path as it is tracked: a pose and a status for every frame, keyframes, and edges between
// them.
#pragma once

#include <cstddef>
#include <span>

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/tracking/odometry_options.h"
#include "deepslam/tracking/posed_frame.h"

namespace deepslam::tracking {

// Diagonal, order (translation; rotation), of one standard deviation each.
[[nodiscard]] Matrix6d DiagonalInformation(double sigma_m, double sigma_deg);

class OdometryBuilder {
 public:
  explicit OdometryBuilder(const OdometryOptions& options);

  // Frames in their order. The first one that is usable.
  void AddFirst(const PosedFrame& frame);
  // Aligned, to `keyframe` or to a frame since.
  void AddAligned(const PosedFrame& frame,
                  FrameIdx keyframe,
                  const alignment::FrameAlignment& alignment);
  // Not aligned, but placed by the recorder's poses.
  void AddCarried(const PosedFrame& frame, FrameIdx keyframe) {
    AddUnaligned(frame, keyframe, TrackingStatus::kDegenerate);
  }
  // With the pose of the frame before.
  void AddUnaligned(const PosedFrame& frame, FrameIdx keyframe, TrackingStatus status);

  // Of a frame that is added already, or is added next.
  void AddKeyframe(FrameIdx frame) { odometry_.keyframes.push_back(frame); }
  // A frame that is added already was placed against itself.
  void Promote(const PosedFrame& keyframe);
  void AddEdge(const PosedFrame& i, const PosedFrame& j, const alignment::FrameAlignment& found);
  // Across a loss: as the frames lie, and of little information.
  void AddUncertainEdge(const PosedFrame& i, const PosedFrame& j);

  // Moves a frame in the world, by its place in the capture.
  void Move(std::size_t frame, const Pose3& motion);
  // Frames from `first` up to `end` are lost, and followed `keyframe`; keyframes and edges from
  // `first` on are none any more.
  void GiveUp(FrameIdx first, FrameIdx end, FrameIdx keyframe);
  // All readable frames so far are lost, and there is no keyframe.
  void GiveUpAll();

  [[nodiscard]] const std::vector<FrameIdx>& keyframes() const { return odometry_.keyframes; }

  // Frames without an alignment of their own lie between their aligned neighbours. Times of all
  // frames, which must not fall. Without frames and edges where there is no keyframe.
  [[nodiscard]] Odometry Finish(std::span<const double> times_s) &&;

 private:
  [[nodiscard]] TrackedFrame& at(FrameIdx frame) {
    return odometry_.frames[static_cast<std::size_t>(frame.value)];
  }

  Matrix6d uncertain_;
  Odometry odometry_;
};

}  // namespace deepslam::tracking
