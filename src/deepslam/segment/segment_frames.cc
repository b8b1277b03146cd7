#include "deepslam/segment/segment_frames.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>

#include "deepslam/core/parallel_ahead.h"
#include "deepslam/scene/upright_turns.h"

namespace deepslam::segment {
namespace {

// Frames whose segments may wait for those of an earlier one.
constexpr std::size_t kAhead = 8;

// Consecutive detections of one frame.
std::vector<std::span<const Detection>> ByFrame(std::span<const Detection> detections) {
  std::vector<std::span<const Detection>> groups;
  for (std::size_t begin = 0; begin < detections.size();) {
    std::size_t end = begin;
    while (end < detections.size() && detections[end].frame == detections[begin].frame) ++end;
    groups.push_back(detections.subspan(begin, end - begin));
    begin = end;
  }
  return groups;
}

std::vector<Segment> SegmentOne(const SegmentationInputs& inputs,
                                std::span<const QuarterTurn> upright,
                                std::span<const Detection> detections,
                                const SegmentOptions& options) {
  const FrameIdx idx = detections.front().frame;
  const Result<Frame> frame = inputs.frames.ReadDepth(idx);
  if (!frame.ok()) return {};
  const std::optional<Plane> ground_camera =
      GroundInCamera(inputs.ground, idx, inputs.trajectory.at(idx).world_from_camera);
  return SegmentFrame({*frame,
                       inputs.frames.camera(),
                       ground_camera,
                       detections,
                       upright[static_cast<std::size_t>(idx.value)]},
                      inputs.classes,
                      options);
}

}  // namespace

Result<std::vector<Segment>> SegmentFrames(const SegmentationInputs& inputs,
                                           const SegmentOptions& options,
                                           Progress& progress) {
  const std::vector<std::span<const Detection>> groups = ByFrame(inputs.detections);
  const std::vector<QuarterTurn> upright = UprightTurns(inputs.trajectory.frames, inputs.ground);
  std::vector<Segment> segments;
  std::vector<std::vector<Segment>> found(kAhead);
  const auto segment = [&](std::size_t i) {
    if (progress.StopRequested()) return;
    found[i % kAhead] = SegmentOne(inputs, upright, groups[i], options);
  };
  const auto take = [&](std::size_t i) {
    if (progress.StopRequested()) return false;
    std::ranges::move(found[i % kAhead], std::back_inserter(segments));
    progress.Report(i + 1, groups.size());
    return true;
  };
  ParallelAhead(groups.size(), kAhead, segment, take);
  if (progress.StopRequested()) return Interrupted();
  return segments;
}

}  // namespace deepslam::segment
