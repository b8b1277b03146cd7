#include "deepslam/stages/judge_object.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/overrides/choices.h"
#include "deepslam/registration/register_shape.h"
#include "deepslam/select/agreement.h"
#include "deepslam/select/confidence.h"
#include "deepslam/select/select.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

Result<ModelMap> LoadModels(const pipeline::StageContext& context,
                            const RunInputs& inputs,
                            std::span<const ShapeCandidate> candidates,
                            const std::map<std::string, VoxelGrid>& own) {
  std::map<std::string, VoxelGrid> grids;
  for (const ShapeCandidate& candidate : candidates) {
    if (grids.contains(candidate.model)) continue;
    if (const auto made = own.find(candidate.model); made != own.end()) {
      grids.insert(*made);
      continue;
    }
    Result<VoxelGrid> grid = ReadModel(context, StageOfModel(candidate.source), candidate.model);
    if (!grid.ok()) return grid.error();
    grids.emplace(candidate.model, std::move(grid).value());
  }
  return PrepareModels(inputs, grids);
}

ModelMap PrepareModels(const RunInputs& inputs, const std::map<std::string, VoxelGrid>& grids) {
  ModelMap models;
  std::vector<std::pair<ModelMap::iterator, const VoxelGrid*>> places;
  for (const auto& [name, grid] : grids)
    places.emplace_back(models.emplace(name, nullptr).first, &grid);
  ParallelFor(places.size(), [&](std::size_t i) {
    const auto& [place, grid] = places[i];
    place->second = Prepared(inputs, place->first, *grid);
  });
  return models;
}

std::vector<ShapeCandidate> CandidatesOf(const Proposals& proposals, ObjectId object) {
  std::vector<ShapeCandidate> candidates;
  for (const ShapeCandidate& candidate : proposals.candidates) {
    if (candidate.object == object) candidates.push_back(candidate);
  }
  return candidates;
}

int NextId(const Proposals& proposals) {
  int next = 0;
  for (const ShapeCandidate& candidate : proposals.candidates)
    next = std::max(next, candidate.id.value + 1);
  return next;
}

std::vector<CandidateRegistration> RegisterAll(std::span<const ShapeCandidate> candidates,
                                               const ModelMap& models,
                                               std::span<const ObjectView> views,
                                               const registration::RegisterOptions& options) {
  const auto prepared = registration::PrepareForRegistration(views, options);
  std::vector<CandidateRegistration> registrations(candidates.size());
  ParallelFor(candidates.size(), [&](std::size_t i) {
    registrations[i] = registration::RegisterCandidate(
        candidates[i], *models.at(candidates[i].model), std::span(prepared), options);
  });
  return registrations;
}

void ScoreAll(std::span<const ObjectView> views,
              const select::SelectOptions& options,
              Contest& contest) {
  if (contest.judged_views.empty())
    contest.judged_views = select::PrepareForScoring(views, options);
  const std::size_t first = contest.scores.size();
  contest.scores.resize(contest.candidates.size());
  ParallelFor(contest.candidates.size() - first, [&](std::size_t n) {
    const std::size_t i = first + n;
    contest.scores[i] = select::ScoreCandidate(contest.candidates[i],
                                               *contest.models.at(contest.candidates[i].model),
                                               contest.registrations[i],
                                               std::span(std::as_const(contest.judged_views)),
                                               options);
  });
}

void Enter(Proposals made,
           std::span<const ObjectView> views,
           const RunInputs& inputs,
           int first_id,
           Contest& contest,
           Proposals& all) {
  int next_id = first_id + static_cast<int>(all.candidates.size());
  for (ShapeCandidate& candidate : made.candidates) candidate.id = CandidateId{next_id++};
  contest.models.merge(PrepareModels(inputs, made.models));
  std::vector<CandidateRegistration> registrations =
      RegisterAll(made.candidates, contest.models, views, inputs.config.registration);
  for (std::size_t n = 0; n < made.candidates.size(); ++n) {
    contest.candidates.push_back(made.candidates[n]);
    contest.registrations.push_back(std::move(registrations[n]));
  }
  ScoreAll(views, inputs.config.select, contest);
  Join(std::move(made), all);
}

Result<MapObject> SelectOrChoose(const Contest& contest,
                                 std::span<const ObjectView> views,
                                 const RunInputs& inputs,
                                 std::vector<std::string>& applied) {
  const auto select = [&](std::size_t first, std::size_t count) {
    return select::SelectShape(contest.object,
                               contest.class_name,
                               std::span(contest.candidates).subspan(first, count),
                               std::span(contest.registrations).subspan(first, count),
                               std::span(contest.scores).subspan(first, count),
                               views,
                               inputs.config.select);
  };
  const auto judged = [&](MapObject object) {
    if (object.chosen.valid()) {
      object.confidence = select::Confidence(object,
                                             *contest.models.at(object.model),
                                             contest.candidates,
                                             contest.registrations,
                                             contest.scores,
                                             inputs.config.select);
    }
    return object;
  };
  MapObject best = select(0, contest.candidates.size());
  const Result<CandidateId> wanted =
      overrides::ChosenByHand(inputs.overrides, contest.object, contest.candidates);
  if (!wanted.ok()) return wanted.error();
  if (!wanted->valid() || *wanted == best.chosen) return judged(std::move(best));
  std::size_t n = 0;
  while (contest.candidates[n].id != *wanted) ++n;
  MapObject chosen = select(n, 1);
  if (!chosen.chosen.valid()) {
    const std::string& why = contest.scores[n].note;
    return InvalidConfig(fmt::format(
        "{}: choose: candidate {} of object {} fits nowhere: {}; choose another one, or none",
        inputs.overrides.file,
        wanted->value,
        contest.object.value,
        why.empty() ? "it agrees with none of the depth" : why));
  }
  chosen.note += chosen.note.empty() ? "chosen by hand" : "; chosen by hand";
  chosen.scores = std::move(best.scores);
  chosen.history = std::move(best.history);
  applied.push_back(fmt::format("object {} is candidate {} ({}) by choice",
                                contest.object.value,
                                wanted->value,
                                chosen.model));
  return judged(std::move(chosen));
}

}  // namespace deepslam::stages
