// The votes of the frames that the detector looked at, one frame after the other.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "deepslam/core/parallel_ahead.h"
#include "deepslam/discovery/find_things.h"
#include "deepslam/instances/view_votes.h"

namespace deepslam::discovery {

[[nodiscard]] std::span<const Detection> DetectionsOf(const ThingInputs& inputs, FrameIdx frame);

// Level world <- camera.
[[nodiscard]] Pose3 LevelFromCamera(const ThingInputs& inputs, FrameIdx frame);

// Reads the depth of these frames, makes something of each side by side, and takes what was made in
// their order. A frame that cannot be read is skipped; `warn`: with a warning.
template <typename Value>
[[nodiscard]] Status ForDepthFrames(const FrameSource& source,
                                    std::span<const FrameIdx> frames,
                                    bool warn,
                                    Progress& progress,
                                    const std::function<Value(std::size_t, const Frame&)>& make,
                                    const std::function<void(std::size_t, Value)>& take);

struct Claims {
  instances::ViewVotes votes;
  std::vector<instances::FrameClaims> frames;  // one per frame looked at
};
[[nodiscard]] Result<Claims> CollectClaims(const ThingInputs& inputs,
                                           const instances::SurfaceElements& elements,
                                           const instances::Superpoints& superpoints,
                                           const instances::VoteOptions& options,
                                           Progress& progress);

template <typename Value>
Status ForDepthFrames(const FrameSource& source,
                      std::span<const FrameIdx> frames,
                      bool warn,
                      Progress& progress,
                      const std::function<Value(std::size_t, const Frame&)>& make,
                      const std::function<void(std::size_t, Value)>& take) {
  constexpr std::size_t kAhead = 8;  // frames whose images may wait for an earlier one's
  std::vector<std::optional<Result<Value>>> made(kAhead);
  const auto prepare = [&](std::size_t n) {
    made[n % kAhead].reset();
    if (progress.StopRequested()) return;
    const Result<Frame> frame = source.ReadDepth(frames[n]);
    if (frame.ok())
      made[n % kAhead] = make(n, *frame);
    else
      made[n % kAhead] = frame.error();
  };
  const auto use = [&](std::size_t n) {
    std::optional<Result<Value>>& value = made[n % kAhead];
    if (progress.StopRequested() || !value) return false;
    if (value->ok())
      take(n, std::move(*value).value());
    else if (warn)
      progress.Warn(value->error().message);
    return true;
  };
  ParallelAhead(frames.size(), kAhead, prepare, use);
  return progress.StopRequested() ? Interrupted() : Ok();
}

}  // namespace deepslam::discovery
