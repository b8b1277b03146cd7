// select: which candidate is the object's shape.
#include <algorithm>

#include <fmt/format.h>

#include "deepslam/artifact/objects_json.h"
#include "deepslam/stages/apply_overrides.h"
#include "deepslam/stages/judge_object.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

Result<std::vector<CandidateRegistration>> RegistrationsOf(
    std::span<const ShapeCandidate> candidates, std::span<const CandidateRegistration> all) {
  std::vector<CandidateRegistration> found;
  for (const ShapeCandidate& candidate : candidates) {
    const auto it =
        std::find_if(all.begin(), all.end(), [&](const CandidateRegistration& registration) {
          return registration.candidate == candidate.id;
        });
    if (it == all.end()) {
      return InvalidInput(
          fmt::format("register/registrations.json: candidate {} is missing", candidate.id.value));
    }
    found.push_back(*it);
  }
  return found;
}

void Place(MapObject object, ObjectMap& map) {
  if (object.chosen.valid()) {
    map.objects.push_back(std::move(object));
    return;
  }
  map.dropped.push_back(fmt::format(
      "{}: {}", ObjectName(object), object.note.empty() ? "no candidate" : object.note));
}

Result<ObjectMap> SelectAll(const StageContext& context,
                            const RunInputs& inputs,
                            const Odometry& odometry,
                            const Ground& ground,
                            const Association& association,
                            std::vector<std::string>& applied) {
  const Result<Proposals> proposals = ReadProposals(context);
  if (!proposals.ok()) return proposals.error();
  const Result<std::vector<CandidateRegistration>> registrations = ReadRegistrations(context);
  if (!registrations.ok()) return registrations.error();
  ObjectMap map;
  const auto select = [&](const TrackViews& of_track) -> Status {
    const ObjectTrack& track = *of_track.track;
    const std::vector<ShapeCandidate> candidates = CandidatesOf(*proposals, track.id);
    const Result<std::vector<CandidateRegistration>> own =
        RegistrationsOf(candidates, *registrations);
    if (!own.ok()) return own.error();
    const Result<ModelMap> models = LoadModels(context, candidates);
    if (!models.ok()) return models.error();
    Result<MapObject> object = SelectOrChoose(
        track.id, track.class_name, candidates, *own, *models, of_track.views, inputs, applied);
    if (!object.ok()) return object.error();
    Place(std::move(object).value(), map);
    return Ok();
  };
  const Status status = ForEachTrackViews(
      context, inputs, odometry, ground, association.tracks, observe::ViewContent::kDepth, select);
  if (!status.ok()) return status.error();
  return map;
}

}  // namespace

Result<StageSummary> RunSelect(StageContext& context, const RunInputs& inputs) {
  const Result<Odometry> odometry = ReadOdometry(context);
  if (!odometry.ok()) return odometry.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<Association> association = ReadAssociation(context, "associate");
  if (!association.ok()) return association.error();
  std::vector<ObjectId> ids;
  for (const ObjectTrack& track : association->tracks) ids.push_back(track.id);
  if (Status status = CheckChoices(inputs.overrides, ids); !status.ok()) return status.error();
  std::vector<std::string> applied;
  const Result<ObjectMap> map =
      SelectAll(context, inputs, *odometry, *ground, *association, applied);
  if (!map.ok()) return map.error();
  if (Status status = WriteApplied(context, applied); !status.ok()) return status.error();
  if (Status status =
          WriteEncoded(context, "objects.json", artifact::EncodeObjectMap(*map, "objects.json"));
      !status.ok()) {
    return status.error();
  }
  if (Status status = WriteChosenModels(context, *map, "propose"); !status.ok())
    return status.error();
  StageSummary summary{
      fmt::format("{} objects, {} dropped", map->objects.size(), map->dropped.size()),
      {{"num_objects", static_cast<double>(map->objects.size())},
       {"num_dropped", static_cast<double>(map->dropped.size())}}};
  for (const MapObject& object : map->objects) {
    summary.line += fmt::format(", {} {:.2f}", ObjectName(object), object.confidence);
  }
  return summary;
}

}  // namespace deepslam::stages
