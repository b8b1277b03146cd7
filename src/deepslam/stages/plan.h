// The whole chain on one page: which stage reads what, under which options.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/dataset/capture.h"
#include "deepslam/modelling/prepared_models.h"
#include "deepslam/pipeline/stage.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/overrides.h"
#include "deepslam/stages/config.h"
#include "deepslam/stages/content_hashes.h"
#include "deepslam/stages/model_cache.h"

namespace deepslam::stages {

// What every stage may use. Shared by the stages of one plan, which are copied about by value.
struct RunInputs {
  Config config;
  ClassTable classes;
  std::shared_ptr<const dataset::Capture> capture;  // none: the plan can be looked at, not run
  std::filesystem::path data_folder;
  Overrides overrides = {};  // a person's corrections; empty: none
  // Networks and libraries kept between the runs of a process. None: each stage loads what it needs
  // and lets it go, so that a single run's later stages have the memory.
  std::shared_ptr<ModelCache> models = {};
  // What HashModels(), or an earlier run of the process, has hashed already. None: nothing.
  std::shared_ptr<ContentHashes> hashes = {};
  // What stages of this run have prepared for each other. As it is here it keeps nothing: each
  // prepares for itself.
  std::shared_ptr<modelling::PreparedModels> prepared =
      std::make_shared<modelling::PreparedModels>(0);
};
using SharedInputs = std::shared_ptr<const RunInputs>;

// The table of classes the configuration names.
[[nodiscard]] Result<ClassTable> LoadClasses(const Config& config);

// External inputs that come from overrides.yaml.
inline constexpr std::array<std::string_view, 3> kOverrideInputs = {
    "ground_hint", "track_overrides", "choices"};

// Fills inputs.hashes with what networks and libraries of all stages hold, for MakePlan's stages to
// ask for; faults are met again, and told, by the stage that they stop.
void HashModels(const RunInputs& inputs);

// track, ground, detect ... report, in order.
[[nodiscard]] std::vector<pipeline::Stage> MakePlan(SharedInputs inputs);

inline constexpr std::string_view kToolVersion = "0.1.0";

// One function per stage.
[[nodiscard]] Result<pipeline::StageSummary> RunTrack(pipeline::StageContext& context,
                                                      const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunGround(pipeline::StageContext& context,
                                                       const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunLayout(pipeline::StageContext& context,
                                                       const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunDetect(pipeline::StageContext& context,
                                                       const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunSegment(pipeline::StageContext& context,
                                                        const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunAssociate(pipeline::StageContext& context,
                                                          const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunPropose(pipeline::StageContext& context,
                                                        const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunRegister(pipeline::StageContext& context,
                                                         const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunSelect(pipeline::StageContext& context,
                                                       const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunLoops(pipeline::StageContext& context,
                                                      const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunOptimize(pipeline::StageContext& context,
                                                         const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunMesh(pipeline::StageContext& context,
                                                     const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunFuse(pipeline::StageContext& context,
                                                     const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunExport(pipeline::StageContext& context,
                                                       const RunInputs& inputs);
[[nodiscard]] Result<pipeline::StageSummary> RunReport(pipeline::StageContext& context,
                                                       const RunInputs& inputs);

}  // namespace deepslam::stages
