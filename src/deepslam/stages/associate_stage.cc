// associate: which detections are the same object.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/association_json.h"
#include "deepslam/artifact/segments_json.h"
#include "deepslam/discovery/associate_capture.h"
#include "deepslam/overrides/apply_to_tracks.h"
#include "deepslam/scene/measured_parts.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

using pipeline::StageContext;
using pipeline::StageSummary;

namespace {

struct PathOfCapture {
  Trajectory trajectory;
  std::vector<int> part_of_frame;
};

Result<PathOfCapture> ReadPath(const StageContext& context) {
  Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  std::vector<int> parts = PartsOfFrames(*odometry, JoinsOf(*odometry));
  return PathOfCapture{std::move(static_cast<Trajectory&>(*odometry)), std::move(parts)};
}

Result<std::optional<discovery::SurfaceOfCapture>> ReadSurface(const StageContext& context,
                                                               const AssociateStageOptions& options,
                                                               const Layout& layout) {
  if (options.method != kBySurface) return std::optional<discovery::SurfaceOfCapture>();
  Result<CoarseSurface> surface = ReadCoarseSurface(context);
  if (!surface.ok()) return surface.error();
  surface->level_from_tracking = layout.level_from_tracking;
  return std::optional(discovery::SurfaceOfCapture{std::move(surface).value(), layout});
}

Result<discovery::FoundThings> Find(const StageContext& context, const RunInputs& inputs) {
  const Result<PathOfCapture> path = ReadPath(context);
  if (!path.ok()) return path.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<Layout> layout = ReadLayout(context);
  if (!layout.ok()) return layout.error();
  Result<std::optional<discovery::SurfaceOfCapture>> surface =
      ReadSurface(context, inputs.config.associate_stage, *layout);
  if (!surface.ok()) return surface.error();
  if (*surface) (*surface)->surface.has_ground = ground->plane_world.has_value();
  const Result<artifact::DetectionTable> table = ReadDetections(context);
  if (!table.ok()) return table.error();
  std::vector<FrameIdx> looked_at;
  for (const artifact::DetectedImage& image : table->images) looked_at.push_back(image.frame);
  Result<std::vector<Segment>> segments = ReadSegments(context, "segment");
  if (!segments.ok()) return segments.error();
  discovery::ThingOptions by_surface = inputs.config.things;
  by_surface.cut = inputs.config.segment;
  return discovery::AssociateCapture({*inputs.capture->frames,
                                      path->trajectory,
                                      path->part_of_frame,
                                      *ground,
                                      inputs.classes,
                                      looked_at,
                                      table->detections,
                                      *surface,
                                      *layout},
                                     std::move(segments).value(),
                                     inputs.config.associate,
                                     by_surface,
                                     context.progress());
}

StageSummary Summarise(const discovery::FoundThings& found) {
  StageSummary summary{fmt::format("{} objects, {} detections left out",
                                   found.association.tracks.size(),
                                   found.association.rejections.size()),
                       {{"num_objects", static_cast<double>(found.association.tracks.size())}}};
  for (const ObjectTrack& track : found.association.tracks) {
    summary.line +=
        fmt::format(", {}_{:02d} ({})", track.class_name, track.id.value, track.members.size());
  }
  for (const NotMapped& thing : found.association.not_mapped)
    summary.line += "; not mapped: " + thing.what;
  return summary;
}

}  // namespace

Result<StageSummary> RunAssociate(StageContext& context, const RunInputs& inputs) {
  Result<discovery::FoundThings> found = Find(context, inputs);
  if (!found.ok()) return found.error();
  const Result<std::vector<std::string>> applied =
      overrides::ApplyToTracks(inputs.overrides, inputs.classes, found->association);
  if (!applied.ok()) return applied.error();
  if (Status status = WriteApplied(context, *applied); !status.ok()) return status.error();
  const Status segments = context.Write("segments.json", [&](const TextSink& sink) {
    return artifact::EncodeSegments(found->segments, "segments.json", sink);
  });
  if (!segments.ok()) return segments.error();
  const Status tracks = WriteEncoded(
      context, "tracks.json", artifact::EncodeAssociation(found->association, "tracks.json"));
  if (!tracks.ok()) return tracks.error();
  return Summarise(*found);
}

}  // namespace deepslam::stages
