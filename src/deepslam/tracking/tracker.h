// The sequential part of tracking: takes prepared frames in order and places each one against the
// keyframes so far. What it is made of: motion_gate.h (where the camera is expected), placement.h
// and placement_acceptance.h (aligned, and accepted), keyframe_policy.h, relocalisation.h,
// sub_trajectories.h and rejoining.h (losses), dynamic_mask.h (what moves), monotonic_clock.h.
#pragma once

#include <memory>
#include <optional>

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/scene/trajectory.h"
#include "deepslam/tracking/feature_starts.h"
#include "deepslam/tracking/keyframe_window.h"
#include "deepslam/tracking/monotonic_clock.h"
#include "deepslam/tracking/motion_gate.h"
#include "deepslam/tracking/odometry_builder.h"
#include "deepslam/tracking/odometry_options.h"
#include "deepslam/tracking/placement.h"
#include "deepslam/tracking/posed_frame.h"
#include "deepslam/tracking/sub_trajectories.h"

namespace deepslam::tracking {

class Tracker {
 public:
  explicit Tracker(const OdometryOptions& options, FeatureStarts features = {});

  // Frames must come in order, none left out. Null: the frame was unreadable.
  // `recorded`: PosedFrame::recorded.
  void Add(FrameIdx frame,
           double time_s,
           std::shared_ptr<const alignment::FramePyramid> pyramid,
           const std::optional<Pose3>& recorded = std::nullopt);

  // Nothing before the first.
  [[nodiscard]] std::optional<FrameIdx> newest_keyframe() const;

  // Keyframes may be empty when no frame was usable.
  [[nodiscard]] Odometry Finish() &&;

 private:
  [[nodiscard]] PathSoFar Path() const {
    return {options_, keyframes_, *previous_, motion_, &features_};
  }
  [[nodiscard]] bool IsUsable(const alignment::FramePyramid& pyramid) const;
  // Frames of one depth everywhere are as good as a wall only while nothing better has come.
  void ForgetOneDepth();

  // The ways to place a frame, tried in turn; false: it is not placed so.
  bool AlignToReference(PosedFrame& frame);
  bool AlignToPrevious(PosedFrame& frame);
  bool Relocalise(PosedFrame& frame);
  bool CarryOn(PosedFrame& frame);
  bool BeginSubTrajectory(PosedFrame& frame);
  // ... and what becomes of those that are placed, and that are not.
  void Begin(const PosedFrame& frame);
  void AddAligned(const PosedFrame& frame, const alignment::FrameAlignment& found);
  void AddUnaligned(PosedFrame frame, TrackingStatus status);
  void Lose(const PosedFrame& frame);

  // The frame's place, and the motion that it came there by.
  void Accept(PosedFrame& frame,
              const PosedFrame& aligned_to,
              const alignment::FrameAlignment& found);
  // `direct`: the alignment of the frame to the current keyframe where there is one. Moves the
  // frame to where its alignments to the last two keyframes fit best, and a sub-trajectory that has
  // found back to an earlier one with it.
  void AddKeyframe(PosedFrame& frame, const alignment::FrameAlignment* direct);
  void JoinToKeyframes(PosedFrame& frame, const alignment::FrameAlignment* direct);
  void Rejoin(PosedFrame& frame);
  void PushKeyframe(const PosedFrame& frame);
  // Nothing is to be aligned to what walks about.
  void HideDynamic(PosedFrame& frame) const;

  const OdometryOptions options_;
  const FeatureStarts features_;
  MonotonicClock clock_;
  MotionModel motion_;
  KeyframeWindow keyframes_;
  SubTrajectories sub_trajectories_;
  OdometryBuilder odometry_;
  std::optional<PosedFrame> previous_;                             // the last placed frame ...
  std::optional<alignment::FrameAlignment> previous_to_keyframe_;  // ... if to the current keyframe
  std::optional<PosedFrame> pending_;  // a usable frame that could not be placed
  bool seen_measured_ = false;         // a frame of more than one depth
};

}  // namespace deepslam::tracking
