// segment: which pixels of every box are the object.
#include <algorithm>

#include <fmt/format.h>

#include "deepslam/artifact/segments_json.h"
#include "deepslam/segment/segment_frames.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

using pipeline::StageContext;
using pipeline::StageSummary;

Result<StageSummary> RunSegment(StageContext& context, const RunInputs& inputs) {
  const Result<Trajectory> trajectory = ReadTrajectory(context);
  if (!trajectory.ok()) return trajectory.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<artifact::DetectionTable> table = ReadDetections(context);
  if (!table.ok()) return table.error();
  const Result<std::vector<Segment>> segments = segment::SegmentFrames(
      {*inputs.capture->frames, *trajectory, *ground, inputs.classes, table->detections},
      inputs.config.segment,
      context.progress());
  if (!segments.ok()) return segments.error();
  const Status written = context.Write("segments.json", [&](const TextSink& sink) {
    return artifact::EncodeSegments(*segments, "segments.json", sink);
  });
  if (!written.ok()) return written.error();
  const auto usable = std::ranges::count_if(*segments, &Segment::usable);
  return StageSummary{
      fmt::format("{} of {} detections have a usable silhouette", usable, segments->size()),
      {{"num_usable", static_cast<double>(usable)},
       {"num_segments", static_cast<double>(segments->size())}}};
}

}  // namespace deepslam::stages
