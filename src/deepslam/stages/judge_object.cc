#include "deepslam/stages/judge_object.h"

#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/registration/register_shape.h"
#include "deepslam/select/agreement.h"
#include "deepslam/select/select.h"
#include "deepslam/stages/apply_overrides.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {

Result<ModelMap> LoadModels(const pipeline::StageContext& context,
                            std::span<const ShapeCandidate> candidates) {
  std::map<std::string, std::optional<shape::ShapeModel>> wanted;
  for (const ShapeCandidate& candidate : candidates) wanted.emplace(candidate.model, std::nullopt);
  std::vector<std::pair<std::optional<shape::ShapeModel>*, VoxelGrid>> grids;
  for (auto& [key, model] : wanted) {
    Result<VoxelGrid> grid = ReadModel(context, "propose", key);
    if (!grid.ok()) return grid.error();
    grids.emplace_back(&model, std::move(grid).value());
  }
  ParallelFor(grids.size(), [&](std::size_t i) { grids[i].first->emplace(grids[i].second); });
  ModelMap models;
  for (auto& [key, model] : wanted) models.emplace(key, *std::move(model));
  return models;
}

std::vector<ShapeCandidate> CandidatesOf(const Proposals& proposals, ObjectId object) {
  std::vector<ShapeCandidate> candidates;
  for (const ShapeCandidate& candidate : proposals.candidates) {
    if (candidate.object == object) candidates.push_back(candidate);
  }
  return candidates;
}

std::vector<CandidateRegistration> RegisterAll(std::span<const ShapeCandidate> candidates,
                                               const ModelMap& models,
                                               std::span<const ObjectView> views,
                                               const registration::RegisterOptions& options) {
  const auto prepared = registration::PrepareForRegistration(views, options);
  std::vector<CandidateRegistration> registrations(candidates.size());
  ParallelFor(candidates.size(), [&](std::size_t i) {
    registrations[i] = registration::RegisterCandidate(
        candidates[i], models.at(candidates[i].model), std::span(prepared), options);
  });
  return registrations;
}

MapObject ScoreAndSelect(ObjectId id,
                         const std::string& class_name,
                         std::span<const ShapeCandidate> candidates,
                         std::span<const CandidateRegistration> registrations,
                         const ModelMap& models,
                         std::span<const ObjectView> views,
                         const select::SelectOptions& options) {
  const auto judged = select::PrepareForScoring(views, options);
  std::vector<CandidateScore> scores(candidates.size());
  ParallelFor(candidates.size(), [&](std::size_t i) {
    scores[i] = select::ScoreCandidate(candidates[i],
                                       models.at(candidates[i].model),
                                       registrations[i],
                                       std::span(judged),
                                       options);
  });
  return select::SelectShape(id, class_name, candidates, registrations, scores, views, options);
}

Result<MapObject> SelectOrChoose(ObjectId id,
                                 const std::string& class_name,
                                 std::span<const ShapeCandidate> candidates,
                                 std::span<const CandidateRegistration> registrations,
                                 const ModelMap& models,
                                 std::span<const ObjectView> views,
                                 const RunInputs& inputs,
                                 std::vector<std::string>& applied) {
  const select::SelectOptions& options = inputs.config.select;
  MapObject best =
      ScoreAndSelect(id, class_name, candidates, registrations, models, views, options);
  const Result<CandidateId> wanted = ChosenByHand(inputs.overrides, id, candidates);
  if (!wanted.ok()) return wanted.error();
  if (!wanted->valid() || *wanted == best.chosen) return best;
  std::size_t n = 0;
  while (candidates[n].id != *wanted) ++n;
  MapObject chosen = ScoreAndSelect(id,
                                    class_name,
                                    candidates.subspan(n, 1),
                                    registrations.subspan(n, 1),
                                    models,
                                    views,
                                    options);
  if (!chosen.chosen.valid()) {
    return InvalidConfig(fmt::format("{}: candidate {} of object {} fits nowhere: {}",
                                     inputs.overrides.file,
                                     wanted->value,
                                     id.value,
                                     registrations[n].reason));
  }
  chosen.note += chosen.note.empty() ? "chosen by hand" : "; chosen by hand";
  chosen.scores = std::move(best.scores);
  chosen.history = std::move(best.history);
  applied.push_back(fmt::format(
      "object {} is candidate {} ({}) by choice", id.value, wanted->value, chosen.model));
  return chosen;
}

}  // namespace deepslam::stages
