// segment: which pixels of every box are the object.
#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/segments_json.h"
#include "deepslam/core/parallel_ahead.h"
#include "deepslam/scene/upright_turns.h"
#include "deepslam/segment/segment_objects.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

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

std::vector<Segment> SegmentOne(const RunInputs& inputs,
                                const Trajectory& trajectory,
                                const Ground& ground,
                                std::span<const QuarterTurn> upright,
                                std::span<const Detection> detections) {
  const FrameSource& frames = *inputs.capture->frames;
  const FrameIdx idx = detections.front().frame;
  const Result<Frame> frame = frames.ReadDepth(idx);
  if (!frame.ok()) return {};
  return segment::SegmentFrame(*frame,
                               frames.camera(),
                               GroundInCamera(ground, idx, trajectory.at(idx).world_from_camera),
                               detections,
                               inputs.config.segment,
                               upright[static_cast<std::size_t>(idx.value)]);
}

}  // namespace

Result<StageSummary> RunSegment(StageContext& context, const RunInputs& inputs) {
  const Result<Trajectory> trajectory = ReadTrajectory(context);
  if (!trajectory.ok()) return trajectory.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<artifact::DetectionTable> table = ReadDetections(context);
  if (!table.ok()) return table.error();
  const std::vector<std::span<const Detection>> groups = ByFrame(table->detections);
  const std::vector<QuarterTurn> upright = UprightTurns(trajectory->frames, *ground);
  std::vector<Segment> segments;
  std::vector<std::vector<Segment>> found(kAhead);
  const auto look = [&](std::size_t i) {
    if (context.progress().StopRequested()) return;
    found[i % kAhead] = SegmentOne(inputs, *trajectory, *ground, upright, groups[i]);
  };
  const auto take = [&](std::size_t i) {
    if (context.progress().StopRequested()) return false;
    std::vector<Segment>& of_frame = found[i % kAhead];
    std::move(of_frame.begin(), of_frame.end(), std::back_inserter(segments));
    context.progress().Report(i + 1, groups.size());
    return true;
  };
  ParallelAhead(groups.size(), kAhead, look, take);
  if (context.progress().StopRequested()) return Interrupted();
  const Status written = context.Write("segments.json", [&](const TextSink& sink) {
    return artifact::EncodeSegments(segments, "segments.json", sink);
  });
  if (!written.ok()) return written.error();
  const auto usable = std::count_if(
      segments.begin(), segments.end(), [](const Segment& segment) { return segment.usable; });
  return StageSummary{
      fmt::format("{} of {} detections have a usable silhouette", usable, segments.size()),
      {{"num_usable", static_cast<double>(usable)},
       {"num_segments", static_cast<double>(segments.size())}}};
}

}  // namespace deepslam::stages
