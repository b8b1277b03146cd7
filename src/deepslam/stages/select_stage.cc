// select: which candidate is the object's shape.
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/overrides/choices.h"
#include "deepslam/stages/judge_object.h"
#include "deepslam/stages/load_priors.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/read_side_by_side.h"
#include "deepslam/stages/refine_object.h"
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
          fmt::format("register/registrations.json: candidate {} of propose is missing; remove the "
                      "folder of stage register, and run again",
                      candidate.id.value));
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

// What the stage makes.
struct Selection {
  ObjectMap map;
  Proposals made;                                         // candidates added here
  std::vector<CandidateRegistration> made_registrations;  // and what replaces those of register
  std::vector<std::string> applied;                       // of a person's choices
};

// The shape networks, where some candidate is theirs and may be refined.
Result<std::shared_ptr<const propose::ShapePriors>> PriorsToRefine(const RunInputs& inputs,
                                                                   const Proposals& proposals) {
  const bool is_wanted =
      inputs.config.shape_refinement.enabled &&
      std::any_of(proposals.candidates.begin(),
                  proposals.candidates.end(),
                  [](const ShapeCandidate& candidate) { return !candidate.latents.empty(); });
  if (!is_wanted) return std::shared_ptr<const propose::ShapePriors>();
  return PriorsOf(inputs);
}

const propose::ShapePrior* PriorOf(const std::shared_ptr<const propose::ShapePriors>& priors,
                                   const std::string& class_name) {
  if (!priors) return nullptr;
  const auto found = priors->find(class_name);
  return found != priors->end() && found->second->HasGradient() ? found->second.get() : nullptr;
}

// One object's contest when all is scored, with what was made for it: numbered from `first_made`
// on, as if no other object had any.
struct Judged {
  Contest contest;
  std::size_t num_proposed = 0;         // those made here are behind them
  Proposals made;                       // the same, with their models
  std::optional<std::size_t> replaced;  // of the proposed, whose registration was refined
};

Result<Judged> Judge(const StageContext& context,
                     const RunInputs& inputs,
                     const Proposals& proposals,
                     std::span<const CandidateRegistration> registrations,
                     const std::shared_ptr<const propose::ShapePriors>& priors,
                     int first_made,
                     const TrackViews& of_track) {
  const ObjectTrack& track = *of_track.track;
  Judged judged;
  Contest& contest = judged.contest;
  contest.object = track.id;
  contest.class_name = track.class_name;
  contest.candidates = CandidatesOf(proposals, track.id);
  Result<std::vector<CandidateRegistration>> own =
      RegistrationsOf(contest.candidates, registrations);
  if (!own.ok()) return own.error();
  contest.registrations = std::move(own).value();
  Result<ModelMap> models = LoadModels(context, inputs, contest.candidates);
  if (!models.ok()) return models.error();
  contest.models = std::move(models).value();
  ScoreAll(of_track.views, inputs.config.select, contest);
  judged.num_proposed = contest.candidates.size();
  const auto enter = [&](Proposals made) {
    Enter(std::move(made), of_track.views, inputs, first_made, contest, judged.made);
  };
  if (const propose::ShapePrior* const prior = PriorOf(priors, track.class_name))
    enter(RefineShapes(contest, of_track.views, *prior, inputs));
  if (inputs.config.shape_refinement.complete)
    enter(CompleteBest(contest, of_track.views, "filled", inputs));
  judged.replaced = RefineWinner(of_track.views, inputs, contest);
  return judged;
}

// Numbers what was made for the object behind what was made for those before it.
void NumberBehind(int num_before, Judged& judged) {
  for (ShapeCandidate& candidate : judged.made.candidates) candidate.id.value += num_before;
  Contest& contest = judged.contest;
  for (std::size_t n = judged.num_proposed; n < contest.candidates.size(); ++n) {
    contest.candidates[n].id.value += num_before;
    contest.registrations[n].candidate.value += num_before;
    contest.scores[n].candidate.value += num_before;
  }
}

// The object's winner, and what was made for it, into what the stage makes.
Status Keep(const TrackViews& of_track,
            const RunInputs& inputs,
            Judged judged,
            Selection& selection) {
  NumberBehind(static_cast<int>(selection.made.candidates.size()), judged);
  Join(std::move(judged.made), selection.made);
  const Contest& contest = judged.contest;
  if (judged.replaced && *judged.replaced < judged.num_proposed)
    selection.made_registrations.push_back(contest.registrations[*judged.replaced]);
  const auto made = std::span(contest.registrations).subspan(judged.num_proposed);
  selection.made_registrations.insert(selection.made_registrations.end(), made.begin(), made.end());
  Result<MapObject> object = SelectOrChoose(contest, of_track.views, inputs, selection.applied);
  if (!object.ok()) return object.error();
  Place(std::move(object).value(), selection.map);
  return Ok();
}

struct Sources {
  Trajectory trajectory;
  Ground ground;
  Association association;
  Proposals proposals;
  std::vector<CandidateRegistration> registrations;
};

Result<Sources> ReadSources(const StageContext& context) {
  Sources sources;
  const std::array<std::function<Status()>, 5> readers = {
      [&] { return Take(ReadRegistrations(context), sources.registrations); },
      [&] { return Take(ReadTrajectory(context), sources.trajectory); },
      [&] { return Take(ReadProposals(context), sources.proposals); },
      [&] { return Take(ReadAssociation(context, "associate"), sources.association); },
      [&] { return Take(ReadGround(context, "ground"), sources.ground); }};
  if (Status status = ReadSideBySide(readers); !status.ok()) return status.error();
  return sources;
}

Result<Selection> SelectAll(const StageContext& context,
                            const RunInputs& inputs,
                            const Sources& sources) {
  const auto priors = PriorsToRefine(inputs, sources.proposals);
  if (!priors.ok()) return priors.error();
  const int first_made = NextId(sources.proposals);
  Selection selection;
  const Status status = ForEachTrackViews<Judged>(
      context,
      inputs,
      sources.trajectory,
      sources.ground,
      sources.association.tracks,
      observe::ViewContent::kDepth,
      [&](const TrackViews& of_track) {
        return Judge(context,
                     inputs,
                     sources.proposals,
                     sources.registrations,
                     *priors,
                     first_made,
                     of_track);
      },
      [&](const TrackViews& of_track, Judged judged) {
        return Keep(of_track, inputs, std::move(judged), selection);
      });
  if (!status.ok()) return status.error();
  return selection;
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

}  // namespace

Result<StageSummary> RunSelect(StageContext& context, const RunInputs& inputs) {
  const Result<Sources> sources = ReadSources(context);
  if (!sources.ok()) return sources.error();
  if (Status status = overrides::CheckChoices(inputs.overrides, sources->association.tracks);
      !status.ok())
    return status.error();
  const Result<Selection> selection = SelectAll(context, inputs, *sources);
  if (!selection.ok()) return selection.error();
  if (Status status = WriteSelection(context, *selection); !status.ok()) return status.error();
  const ObjectMap& map = selection->map;
  const std::vector<ShapeCandidate>& made = selection->made.candidates;
  const auto num_refined = std::count_if(made.begin(), made.end(), [](const auto& candidate) {
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

}  // namespace deepslam::stages
