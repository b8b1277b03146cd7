// associate: which detections are the same object.
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/association_json.h"
#include "deepslam/associate/associate.h"
#include "deepslam/overrides/apply_to_tracks.h"
#include "deepslam/scene/measured_parts.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

using pipeline::StageContext;
using pipeline::StageSummary;

namespace {

struct PartedTrajectory {
  Trajectory trajectory;
  std::vector<int> part_of_frame;
};

Result<PartedTrajectory> ReadParted(const StageContext& context) {
  Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  std::vector<int> parts = PartsOfFrames(*odometry, JoinsOf(*odometry));
  return PartedTrajectory{std::move(static_cast<Trajectory&>(*odometry)), std::move(parts)};
}

}  // namespace

Result<StageSummary> RunAssociate(StageContext& context, const RunInputs& inputs) {
  const Result<PartedTrajectory> path = ReadParted(context);
  if (!path.ok()) return path.error();
  Result<std::vector<Segment>> segments = ReadSegments(context);
  if (!segments.ok()) return segments.error();
  Result<Association> association = associate::Associate(*inputs.capture->frames,
                                                         path->trajectory,
                                                         path->part_of_frame,
                                                         std::move(segments).value(),
                                                         inputs.config.associate,
                                                         context.progress());
  if (!association.ok()) return association.error();
  const Result<std::vector<std::string>> applied =
      overrides::ApplyToTracks(inputs.overrides, inputs.classes, *association);
  if (!applied.ok()) return applied.error();
  if (Status status = WriteApplied(context, *applied); !status.ok()) return status.error();
  if (Status status = WriteEncoded(
          context, "tracks.json", artifact::EncodeAssociation(*association, "tracks.json"));
      !status.ok()) {
    return status.error();
  }
  StageSummary summary{fmt::format("{} objects, {} detections left out",
                                   association->tracks.size(),
                                   association->rejections.size()),
                       {{"num_objects", static_cast<double>(association->tracks.size())}}};
  for (const ObjectTrack& track : association->tracks) {
    summary.line +=
        fmt::format(", {}_{:02d} ({})", track.class_name, track.id.value, track.members.size());
  }
  return summary;
}

}  // namespace deepslam::stages
