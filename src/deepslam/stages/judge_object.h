// Registering and selecting the candidates of one object: what stages register, select and loops
// share.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/select/agreement.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/prepared_models.h"

namespace deepslam::stages {

using ModelMap = std::map<std::string, PreparedModel>;

// The models of the candidates, prepared: `own`, or from the stages that made them.
[[nodiscard]] Result<ModelMap> LoadModels(const pipeline::StageContext& context,
                                          const RunInputs& inputs,
                                          std::span<const ShapeCandidate> candidates,
                                          const std::map<std::string, VoxelGrid>& own = {});

[[nodiscard]] ModelMap PrepareModels(const RunInputs& inputs,
                                     const std::map<std::string, VoxelGrid>& grids);

// The candidates of one object, in order of ids.
[[nodiscard]] std::vector<ShapeCandidate> CandidatesOf(const Proposals& proposals, ObjectId object);

// The first number that no candidate has.
[[nodiscard]] int NextId(const Proposals& proposals);

// One registration per candidate, in parallel.
[[nodiscard]] std::vector<CandidateRegistration> RegisterAll(
    std::span<const ShapeCandidate> candidates,
    const ModelMap& models,
    std::span<const ObjectView> views,
    const registration::RegisterOptions& options);

// The candidates of one object, where they stand and how well they agree. The vectors run in
// parallel but for the views' own; scores may be behind.
struct Contest {
  ObjectId object;
  std::string class_name;
  std::vector<ShapeCandidate> candidates;
  std::vector<CandidateRegistration> registrations;
  ModelMap models;
  std::vector<CandidateScore> scores;
  std::vector<select::JudgedView> judged_views;  // made when something is scored first
};

// Scores the candidates that have no score yet, in parallel.
void ScoreAll(std::span<const ObjectView> views,
              const select::SelectOptions& options,
              Contest& contest);

// Candidates made of those of the contest enter it, placed and scored, and join `all` that a stage
// made, which are numbered from `first_id` on.
void Enter(Proposals made,
           std::span<const ObjectView> views,
           const RunInputs& inputs,
           int first_id,
           Contest& contest,
           Proposals& all);

// The winner of a contest that is scored; but what a person chose wins, and `applied` gets a
// sentence then. Errors: no such candidate; one that could not be registered.
[[nodiscard]] Result<MapObject> SelectOrChoose(const Contest& contest,
                                               std::span<const ObjectView> views,
                                               const RunInputs& inputs,
                                               std::vector<std::string>& applied);

}  // namespace deepslam::stages
