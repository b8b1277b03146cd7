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
#include "deepslam/shape/shape_model.h"
#include "deepslam/stages/plan.h"

namespace deepslam::stages {

using ModelMap = std::map<std::string, shape::ShapeModel>;

// The models of the candidates, prepared, from propose/models.
[[nodiscard]] Result<ModelMap> LoadModels(const pipeline::StageContext& context,
                                          std::span<const ShapeCandidate> candidates);

// The candidates of one object, in order of ids.
[[nodiscard]] std::vector<ShapeCandidate> CandidatesOf(const Proposals& proposals, ObjectId object);

// One registration per candidate, in parallel.
[[nodiscard]] std::vector<CandidateRegistration> RegisterAll(
    std::span<const ShapeCandidate> candidates,
    const ModelMap& models,
    std::span<const ObjectView> views,
    const registration::RegisterOptions& options);

// Scores every candidate in parallel and chooses.
[[nodiscard]] MapObject ScoreAndSelect(ObjectId id,
                                       const std::string& class_name,
                                       std::span<const ShapeCandidate> candidates,
                                       std::span<const CandidateRegistration> registrations,
                                       const ModelMap& models,
                                       std::span<const ObjectView> views,
                                       const select::SelectOptions& options);

// ScoreAndSelect, but what a person chose wins; `applied` gets a sentence then. Errors: no such
// candidate; one that could not be registered.
[[nodiscard]] Result<MapObject> SelectOrChoose(ObjectId id,
                                               const std::string& class_name,
                                               std::span<const ShapeCandidate> candidates,
                                               std::span<const CandidateRegistration> registrations,
                                               const ModelMap& models,
                                               std::span<const ObjectView> views,
                                               const RunInputs& inputs,
                                               std::vector<std::string>& applied);

}  // namespace deepslam::stages
