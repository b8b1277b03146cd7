// The candidates of one object: their models, where they stand, and how well they agree with depth.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/modelling/object_options.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/select/agreement.h"

namespace deepslam::modelling {

using ModelMap = std::map<std::string, PreparedModel>;
using GridMap = std::map<std::string, VoxelGrid>;

// The models of the candidates, prepared: those that were `made` here, others from the source.
[[nodiscard]] Result<ModelMap> LoadModels(std::span<const ShapeCandidate> candidates,
                                          const ModelSource& source,
                                          PreparedModels& prepared,
                                          const GridMap& made = {});

[[nodiscard]] ModelMap PrepareModels(const GridMap& grids, PreparedModels& prepared);

// The candidates of one object, in order of ids.
[[nodiscard]] std::vector<ShapeCandidate> CandidatesOf(const Proposals& proposals, ObjectId object);

// Behind those that are there, in their order.
void Append(Proposals more, Proposals& all);

// The first number that no candidate has.
[[nodiscard]] int NextId(const Proposals& proposals);

// One registration per candidate of an object of the class, in parallel.
[[nodiscard]] std::vector<CandidateRegistration> RegisterAll(
    std::span<const ShapeCandidate> candidates,
    const ModelMap& models,
    std::span<const ObjectView> views,
    std::string_view class_name,
    const ObjectOptions& options);

// The vectors run in parallel but for the views' own; scores may be behind.
struct CandidateSet {
  ObjectId object;
  std::string class_name;
  std::vector<ShapeCandidate> candidates;
  std::vector<CandidateRegistration> registrations;
  ModelMap models;
  std::vector<CandidateScore> scores;
  std::vector<select::ScoredView> scored_views;  // made when something is scored first
};

// Scores the candidates that have no score yet, in parallel.
void ScoreAll(std::span<const ObjectView> views, const ObjectOptions& options, CandidateSet& set);

// Candidates made of those of the set, numbered already, join it: registered and scored. What
// followed the depth so far that its front has come to stand at a wall, and its back free, has its
// front on the other side: its model is turned half round, in `made` as well, and stays in place.
void AddCandidates(Proposals& made,
                   std::span<const ObjectView> views,
                   const ObjectOptions& options,
                   PreparedModels& prepared,
                   CandidateSet& set);

// Numbers them from `first_id` on.
void NumberFrom(int first_id, Proposals& proposals);

// The winner of a set that is scored; but what a person chose wins, and `applied` gets a sentence
// then. Errors: no such candidate; one that could not be registered.
[[nodiscard]] Result<MapObject> SelectOrChoose(const CandidateSet& set,
                                               std::span<const ObjectView> views,
                                               const ObjectOptions& options,
                                               std::vector<std::string>& applied);

}  // namespace deepslam::modelling
