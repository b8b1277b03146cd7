#include "deepslam/tracking/tracker.h"

#include <cstddef>
#include <utility>

#include "deepslam/tracking/dynamic_mask.h"
#include "deepslam/tracking/keyframe_policy.h"
#include "deepslam/tracking/rejoining.h"
#include "deepslam/tracking/relocalisation.h"

namespace deepslam::tracking {

using alignment::FrameAlignment;
using alignment::Sharpened;

Tracker::Tracker(const OdometryOptions& options, FeatureStarts features)
    : options_(options),
      features_(std::move(features)),
      motion_(options.motion_prediction),
      keyframes_(options.num_relocalisation_keyframes),
      odometry_(options) {}

void Tracker::Add(FrameIdx idx,
                  double time_s,
                  std::shared_ptr<const FramePyramid> pyramid,
                  const std::optional<Pose3>& recorded) {
  PosedFrame frame{idx, time_s, clock_.Advance(time_s), std::move(pyramid), Pose3{}, 0, recorded};
  if (frame.pyramid == nullptr) return AddUnaligned(frame, TrackingStatus::kUnreadable);
  if (!IsUsable(*frame.pyramid)) return AddUnaligned(frame, TrackingStatus::kLost);
  if (!frame.pyramid->one_depth && !std::exchange(seen_measured_, true)) ForgetOneDepth();
  frame.sub_trajectory = sub_trajectories_.newest();
  if (keyframes_.empty()) return Begin(frame);
  const bool is_placed = AlignToReference(frame) || AlignToPrevious(frame) || Relocalise(frame) ||
                         CarryOn(frame) || BeginSubTrajectory(frame);
  if (!is_placed) Lose(frame);
}

bool Tracker::IsUsable(const FramePyramid& pyramid) const {
  if (pyramid.valid_share < OdometryOptions::kMinValidShare) return false;
  return !(pyramid.one_depth && seen_measured_);
}

void Tracker::ForgetOneDepth() {
  if (odometry_.keyframes().empty()) return;
  odometry_.GiveUpAll();
  keyframes_.Clear();
  sub_trajectories_.Reset();
  motion_ = MotionModel(options_.motion_prediction);
  previous_.reset();
  previous_to_keyframe_.reset();
  pending_.reset();
}

void Tracker::Begin(const PosedFrame& frame) {
  odometry_.AddFirst(frame);
  sub_trajectories_.Add(frame.sub_trajectory);
  PushKeyframe(frame);
  previous_ = frame;
}

bool Tracker::AlignToReference(PosedFrame& frame) {
  const bool is_to_previous = options_.reference == "previous";
  if (is_to_previous) MakeReference(*previous_);
  const PosedFrame reference = is_to_previous ? *previous_ : keyframes_.last();
  const PathSoFar path = Path();
  FrameAlignment found =
      Place(path, reference, *previous_, frame, StartsBehindPrevious(path, frame));
  if (!found.ok) return false;
  // From frame to frame each end carries on.
  if (is_to_previous)
    found = Sharpened(found, *reference.pyramid, *frame.pyramid, options_.alignment);
  Accept(frame, reference, found);
  previous_to_keyframe_ = is_to_previous ? std::nullopt : std::optional(found);
  const FrameAlignment* const direct = is_to_previous ? nullptr : &found;
  if (WantsKeyframe(keyframes_.last(), frame, direct, options_)) AddKeyframe(frame, direct);
  AddAligned(frame, found);
  return true;
}

// Too far from the keyframe, but still near the frame before: that one becomes the keyframe.
bool Tracker::AlignToPrevious(PosedFrame& frame) {
  if (options_.reference == "previous" || previous_->frame == keyframes_.last().frame) return false;
  HideDynamic(*previous_);
  MakeReference(*previous_);
  const PathSoFar path = Path();
  FrameAlignment found =
      Place(path, *previous_, *previous_, frame, StartsBehindPrevious(path, frame));
  if (!found.ok) found = PlaceByFeatures(path, *previous_, *previous_, frame);
  if (!found.ok) return false;
  const std::optional<FrameAlignment> direct = previous_to_keyframe_;
  AddKeyframe(*previous_, direct ? &*direct : nullptr);
  odometry_.Promote(*previous_);
  Accept(frame, *previous_, found);
  previous_to_keyframe_ = found;
  AddAligned(frame, found);
  return true;
}

bool Tracker::Relocalise(PosedFrame& frame) {
  const std::optional<Relocalisation> at = tracking::Relocalise(Path(), frame);
  if (!at) return false;
  Accept(frame, at->keyframe, at->alignment);
  motion_.Forget();  // the motion across a loss predicts nothing
  odometry_.AddEdge(at->keyframe, frame, at->alignment);
  if (at->keyframe.frame != keyframes_.last().frame)
    odometry_.AddUncertainEdge(keyframes_.last(), frame);
  PushKeyframe(frame);
  previous_to_keyframe_.reset();
  AddAligned(frame, at->alignment);
  return true;
}

// Where nothing fits, the path goes on as the recorder has it.
bool Tracker::CarryOn(PosedFrame& frame) {
  const std::optional<Pose3> recorded = RecordedPose(*previous_, frame);
  if (!recorded) return false;
  frame.world_from_camera = *recorded;
  frame.sub_trajectory = previous_->sub_trajectory;
  motion_.Forget();
  pending_.reset();
  previous_to_keyframe_.reset();
  if (IsFarFrom(keyframes_.last().world_from_camera, frame.world_from_camera, options_)) {
    odometry_.AddUncertainEdge(keyframes_.last(), frame);
    PushKeyframe(frame);
  }
  odometry_.AddCarried(frame, keyframes_.last().frame);
  sub_trajectories_.Add(frame.sub_trajectory);
  previous_ = frame;
  return true;
}

// The frame before was lost as well, but the two fit together.
bool Tracker::BeginSubTrajectory(PosedFrame& frame) {
  if (!pending_) return false;
  PosedFrame start = *pending_;
  start.sub_trajectory = sub_trajectories_.newest() + 1;
  MakeReference(start);
  FrameAlignment found = Place(Path(), start, start, frame, {{start.world_from_camera}, &start});
  if (!found.ok) found = PlaceByFeatures(Path(), start, start, frame);
  if (!found.ok) return false;
  sub_trajectories_.Begin(start.frame);
  odometry_.AddUncertainEdge(keyframes_.last(), start);
  PushKeyframe(start);
  odometry_.Promote(start);
  previous_ = start;
  Accept(frame, start, found);
  previous_to_keyframe_ = found;
  AddAligned(frame, found);
  return true;
}

void Tracker::Accept(PosedFrame& frame, const PosedFrame& aligned_to, const FrameAlignment& found) {
  frame.world_from_camera = aligned_to.world_from_camera * found.i_from_j;
  frame.sub_trajectory = aligned_to.sub_trajectory;
  motion_.Observe(previous_->world_from_camera.Inverse() * frame.world_from_camera,
                  frame.clock_s - previous_->clock_s,
                  found.remapped);
  pending_.reset();
}

void Tracker::AddAligned(const PosedFrame& frame, const FrameAlignment& found) {
  odometry_.AddAligned(frame, keyframes_.last().frame, found);
  sub_trajectories_.Add(frame.sub_trajectory);
  previous_ = frame;
}

void Tracker::AddUnaligned(PosedFrame frame, TrackingStatus status) {
  if (previous_) frame.world_from_camera = previous_->world_from_camera;
  const FrameIdx keyframe = keyframes_.empty() ? FrameIdx{} : keyframes_.last().frame;
  // Without depth there is nothing to align, but the recorder may have seen more.
  const auto recorded = previous_ ? RecordedPose(*previous_, frame) : std::nullopt;
  if (recorded && status == TrackingStatus::kLost) {
    frame.world_from_camera = *recorded;
    odometry_.AddCarried(frame, keyframe);
  } else {
    odometry_.AddUnaligned(frame, keyframe, status);
  }
  sub_trajectories_.Add(previous_ ? previous_->sub_trajectory : 0);
}

void Tracker::Lose(const PosedFrame& frame) {
  AddUnaligned(frame, TrackingStatus::kLost);
  pending_ = frame;
  pending_->world_from_camera = previous_->world_from_camera;
  motion_.Forget();
}

void Tracker::AddKeyframe(PosedFrame& frame, const FrameAlignment* direct) {
  HideDynamic(frame);
  JoinToKeyframes(frame, direct);
  Rejoin(frame);
  PushKeyframe(frame);
  previous_to_keyframe_.reset();
}

void Tracker::JoinToKeyframes(PosedFrame& frame, const FrameAlignment* direct) {
  const PosedFrame& last = keyframes_.last();
  const FrameAlignment found = Sharpened(
      direct != nullptr ? *direct : AlignTo(Path(), last, frame, {frame.world_from_camera}),
      *last.pyramid,
      *frame.pyramid,
      options_.alignment);
  if (!found.ok) return odometry_.AddUncertainEdge(last, frame);
  if (direct != nullptr) frame.world_from_camera = last.world_from_camera * found.i_from_j;
  odometry_.AddEdge(last, frame, found);
}

// The sub-trajectory that began behind a loss is carried over as soon as one of its keyframes fits
// an earlier keyframe.
void Tracker::Rejoin(PosedFrame& frame) {
  const auto found = FindRejoining(Path(), frame, sub_trajectories_, clock_);
  if (!found) return;
  const int joining = frame.sub_trajectory;
  const int into = found->keyframe.sub_trajectory;
  if (found->gives_up) {
    const FrameIdx start = sub_trajectories_.StartOf(joining);
    odometry_.GiveUp(start, frame.frame, found->keyframe.frame);
    keyframes_.GiveUpFrom(start);
  }
  for (const std::size_t k : sub_trajectories_.Join(joining, into))
    odometry_.Move(k, found->motion);
  keyframes_.Join(joining, into, found->motion);
  for (PosedFrame* const carried : {&*previous_, &frame}) {  // may be the same one
    if (carried->sub_trajectory != joining) continue;
    carried->world_from_camera = found->motion * carried->world_from_camera;
    carried->sub_trajectory = into;
  }
  odometry_.AddEdge(found->keyframe, frame, found->alignment);
  if (found->gives_up && found->keyframe.frame != keyframes_.last().frame)
    odometry_.AddUncertainEdge(keyframes_.last(), frame);
}

void Tracker::PushKeyframe(const PosedFrame& frame) {
  odometry_.AddKeyframe(frame.frame);
  keyframes_.Push(frame);
}

void Tracker::HideDynamic(PosedFrame& frame) const {
  if (options_.reference == "previous") return;  // the paper's plain behaviour
  frame.pyramid = WithoutDynamic(
      frame.Placed(), keyframes_.PlacedOf(frame.sub_trajectory), options_.alignment.pyramid.noise);
}

std::optional<FrameIdx> Tracker::newest_keyframe() const {
  if (odometry_.keyframes().empty()) return std::nullopt;
  return odometry_.keyframes().back();
}

Odometry Tracker::Finish() && { return std::move(odometry_).Finish(clock_.times_s()); }

}  // namespace deepslam::tracking
