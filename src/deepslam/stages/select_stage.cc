// select: which candidate is the object's shape.
#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <set>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/core/side_by_side.h"
#include "deepslam/modelling/select_objects.h"
#include "deepslam/overrides/choices.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/stages/model_cache.h"
#include "deepslam/stages/object_sources.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using modelling::Selection;
using pipeline::StageContext;
using pipeline::StageSummary;

struct Sources {
  Trajectory trajectory;
  Ground ground;
  Layout layout;
  Association association;
  Proposals proposals;
  std::vector<CandidateRegistration> registrations;
};

Result<Sources> ReadSources(const StageContext& context) {
  Sources sources;
  const std::array<std::function<Status()>, 6> readers = {
      [&] { return Take(ReadRegistrations(context), sources.registrations); },
      [&] { return Take(ReadTrajectory(context), sources.trajectory); },
      [&] { return Take(ReadProposals(context), sources.proposals); },
      [&] { return Take(ReadAssociation(context, "associate"), sources.association); },
      [&] { return Take(ReadGround(context, "ground"), sources.ground); },
      [&] { return Take(ReadLayout(context), sources.layout); }};
  if (Status status = RunSideBySide(readers); !status.ok()) return status.error();
  return sources;
}

Status CheckRegistered(const Sources& sources) {
  std::set<ObjectId> tracked;
  for (const ObjectTrack& track : sources.association.tracks) tracked.insert(track.id);
  std::set<CandidateId> registered;
  for (const CandidateRegistration& registration : sources.registrations)
    registered.insert(registration.candidate);
  for (const ShapeCandidate& candidate : sources.proposals.candidates) {
    if (registered.contains(candidate.id) || !tracked.contains(candidate.object)) continue;
    return InvalidInput(
        fmt::format("register/registrations.json: candidate {} of propose is missing; remove the "
                    "folder of stage register, and run again",
                    candidate.id.value));
  }
  return Ok();
}

// The shape networks, where some candidate is theirs and may be refined.
Result<std::shared_ptr<const propose::ShapePriors>> PriorsToRefine(const RunInputs& inputs,
                                                                   const Proposals& proposals) {
  const bool is_wanted =
      inputs.config.shape_refinement.enabled &&
      std::ranges::any_of(proposals.candidates, [](const ShapeCandidate& candidate) {
        return !candidate.latents.empty();
      });
  if (!is_wanted) return std::shared_ptr<const propose::ShapePriors>();
  return FindShapePriors(
      {inputs.data_folder, inputs.models}, inputs.config.propose_stage.priors, inputs.classes);
}

Result<Selection> Select(const StageContext& context,
                         const RunInputs& inputs,
                         const Sources& sources) {
  const auto priors = PriorsToRefine(inputs, sources.proposals);
  if (!priors.ok()) return priors.error();
  const auto views =
      OpenViews(context, *inputs.capture->frames, inputs.classes, inputs.config.views);
  if (!views.ok()) return views.error();
  modelling::ObjectOptions options = ObjectOptionsOf(inputs.config, inputs.overrides);
  options.layout = &sources.layout;
  options.classes = &inputs.classes;
  return modelling::SelectObjects(
      {sources.association.tracks, sources.trajectory, sources.ground},
      {sources.proposals, sources.registrations, priors->get()},
      {*views, StageModels(context), *inputs.prepared, context.progress()},
      options);
}

// overrides.json, objects.json, candidates.json, registrations.json and models/.
Status WriteSelection(StageContext& context, const Selection& selection) {
  if (Status status = WriteApplied(context, selection.applied); !status.ok()) return status;
  const Status written = WriteFiles(
      context,
      {{"objects.json", [&] { return artifact::EncodeObjectMap(selection.map, "objects.json"); }},
       {"candidates.json",
        [&] { return artifact::EncodeProposals(selection.made, "candidates.json"); }},
       {"registrations.json", [&] {
          return artifact::EncodeRegistrations(selection.made_registrations, "registrations.json");
        }}});
  if (!written.ok()) return written;
  if (Status status = WriteModels(context, selection.made.models); !status.ok()) return status;
  return CopyChosenModels(context, selection.map, selection.made.models);
}

StageSummary Summarise(const Selection& selection) {
  const ObjectMap& map = selection.map;
  const std::vector<ShapeCandidate>& made = selection.made.candidates;
  const auto num_refined = std::ranges::count_if(made, [](const ShapeCandidate& candidate) {
    return TraitsOf(candidate.source).can_be_completed;
  });
  const auto num_completed = std::ssize(made) - num_refined;
  StageSummary summary{
      fmt::format("{} objects, {} dropped", map.objects.size(), map.dropped.size()),
      {{"num_objects", static_cast<double>(map.objects.size())},
       {"num_dropped", static_cast<double>(map.dropped.size())},
       {"num_refined", static_cast<double>(num_refined)},
       {"num_completed", static_cast<double>(num_completed)}}};
  if (num_refined > 0) summary.line += fmt::format(", {} shapes refined", num_refined);
  if (num_completed > 0) summary.line += fmt::format(", {} completed", num_completed);
  for (const MapObject& object : map.objects) {
    summary.line += fmt::format(", {} {:.2f}", ObjectName(object), object.confidence);
  }
  return summary;
}

}  // namespace

Result<StageSummary> RunSelect(StageContext& context, const RunInputs& inputs) {
  const Result<Sources> sources = ReadSources(context);
  if (!sources.ok()) return sources.error();
  if (Status status = overrides::CheckChoices(inputs.overrides, sources->association.tracks);
      !status.ok())
    return status.error();
  if (Status status = CheckRegistered(*sources); !status.ok()) return status.error();
  const Result<Selection> selection = Select(context, inputs, *sources);
  if (!selection.ok()) return selection.error();
  if (Status status = WriteSelection(context, *selection); !status.ok()) return status.error();
  return Summarise(*selection);
}

}  // namespace deepslam::stages
