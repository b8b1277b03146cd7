#include "deepslam/discovery/frame_claims.h"

#include <algorithm>
#include <utility>

namespace deepslam::discovery {

std::span<const Detection> DetectionsOf(const ThingInputs& inputs, FrameIdx frame) {
  const auto [begin, end] =
      std::ranges::equal_range(inputs.detections, frame, {}, &Detection::frame);
  return {begin, end};
}

Pose3 LevelFromCamera(const ThingInputs& inputs, FrameIdx frame) {
  return inputs.surface.level_from_tracking * inputs.trajectory.at(frame).world_from_camera;
}

Result<Claims> CollectClaims(const ThingInputs& inputs,
                             const instances::SurfaceElements& elements,
                             const instances::Superpoints& superpoints,
                             const instances::VoteOptions& options,
                             Progress& progress) {
  Claims claims;
  claims.frames.resize(inputs.looked_at.size());
  claims.votes.classes.resize(static_cast<std::size_t>(superpoints.count()));
  claims.votes.num_views.resize(static_cast<std::size_t>(superpoints.count()), 0);
  const auto claim = [&](std::size_t n, const Frame& frame) {
    const std::span<const Detection> detections = DetectionsOf(inputs, inputs.looked_at[n]);
    const instances::VotingView view{&frame.depth_m,
                                     inputs.frames.camera(),
                                     LevelFromCamera(inputs, inputs.looked_at[n]).Inverse(),
                                     detections};
    return instances::ClaimSuperpoints(
        superpoints, instances::FindVisible(elements, view, options), detections, options);
  };
  const auto vote = [&](std::size_t n, instances::FrameClaims of_frame) {
    instances::AddVotes(
        of_frame, DetectionsOf(inputs, inputs.looked_at[n]), superpoints.count(), claims.votes);
    claims.frames[n] = std::move(of_frame);
  };
  const Status status = ForDepthFrames<instances::FrameClaims>(
      inputs.frames, inputs.looked_at, true, progress, claim, vote);
  if (!status.ok()) return status.error();
  return claims;
}

}  // namespace deepslam::discovery
