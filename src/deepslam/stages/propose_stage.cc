// propose: whole shapes for every object, from every source that is switched on.
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/json_value.h"
#include "deepslam/artifact/proposals_json.h"
#include "deepslam/modelling/propose_objects.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/stages/model_cache.h"
#include "deepslam/stages/object_sources.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

struct Sources {
  modelling::CandidateSources of_candidates;
  // Shared by the retrieval source and by this stage, which notes the checksums of the models
  // offered.
  std::shared_ptr<const ModelLibrary> library;
};

std::set<std::string> ClassesOf(const std::vector<ObjectTrack>& tracks) {
  std::set<std::string> names;
  for (const ObjectTrack& track : tracks) names.insert(track.class_name);
  return names;
}

Result<Sources> MakeSources(const RunInputs& inputs,
                            const std::vector<ObjectTrack>& tracks,
                            Progress& progress) {
  const Config& config = inputs.config;
  const ClassTable& classes = inputs.classes;
  const ModelFolders folders = {inputs.data_folder, inputs.models};
  const bool use_depth = config.propose_stage.use_depth;
  const auto channels =
      use_depth ? propose::InputChannels::kColourAndDepth : propose::InputChannels::kColour;
  Sources sources;
  sources.of_candidates.use_depth = use_depth;
  auto& proposers = sources.of_candidates.proposers;
  if (config.propose_stage.retrieval) {
    auto library = FindModelLibrary(folders, config.propose_stage.library);
    if (!library.ok()) return library.error();
    sources.library = std::move(library).value();
    proposers.push_back(
        propose::MakeRetrievalProposer(sources.library, classes, config.retrieval, channels));
  }
  if (config.propose_stage.fused && use_depth) {
    proposers.push_back(propose::MakeFusedProposer(classes));
  }
  if (config.propose_stage.network) {
    const auto priors =
        FindShapePriors(folders, config.propose_stage.priors, classes, ClassesOf(tracks));
    if (!priors.ok()) return priors.error();
    if (!*priors) {
      progress.Warn(
          "no shape networks are there; shapes come from the other sources alone "
          "(propose.priors names a folder with networks)");
      return sources;
    }
    proposers.push_back(
        propose::MakeNetworkProposer(**priors, classes, config.shape_network, channels));
  }
  return sources;
}

// library_models.json: checksums of the library models among the candidates, for the map.
Result<std::string> EncodeLibraryModels(const Sources& sources, const Proposals& proposals) {
  artifact::JsonObject models;
  for (const ShapeCandidate& candidate : proposals.candidates) {
    if (candidate.library_id.empty() || !sources.library) continue;
    for (const LibraryModel& model : sources.library->models) {
      if (model.id == candidate.library_id) models.emplace(model.id, model.checksum);
    }
  }
  artifact::JsonObject document;
  document.emplace("format", "deepslam/library_models");
  document.emplace("version", 1);
  document.emplace("models", std::move(models));
  return DumpJson(std::move(document), "library_models.json");
}

}  // namespace

Result<StageSummary> RunPropose(StageContext& context, const RunInputs& inputs) {
  const Result<Trajectory> trajectory = ReadTrajectory(context);
  if (!trajectory.ok()) return trajectory.error();
  const Result<Ground> ground = ReadGround(context, "ground");
  if (!ground.ok()) return ground.error();
  const Result<Association> association = ReadAssociation(context, "associate");
  if (!association.ok()) return association.error();
  const Result<Layout> layout = ReadLayout(context);
  if (!layout.ok()) return layout.error();
  Result<Sources> sources = MakeSources(inputs, association->tracks, context.progress());
  if (!sources.ok()) return sources.error();
  sources->of_candidates.layout = &*layout;
  const auto views =
      OpenViews(context, *inputs.capture->frames, inputs.classes, inputs.config.views);
  if (!views.ok()) return views.error();
  const Result<Proposals> proposals =
      modelling::ProposeObjects({association->tracks, *trajectory, *ground},
                                sources->of_candidates,
                                *views,
                                context.progress());
  if (!proposals.ok()) return proposals.error();

  if (Status status = WriteEncoded(
          context, "candidates.json", artifact::EncodeProposals(*proposals, "candidates.json"));
      !status.ok()) {
    return status.error();
  }
  if (Status status =
          WriteEncoded(context, "library_models.json", EncodeLibraryModels(*sources, *proposals));
      !status.ok()) {
    return status.error();
  }
  if (Status status = WriteModels(context, proposals->models); !status.ok()) return status.error();
  return StageSummary{fmt::format("{} candidates for {} objects, {} models",
                                  proposals->candidates.size(),
                                  association->tracks.size(),
                                  proposals->models.size()),
                      {{"num_candidates", static_cast<double>(proposals->candidates.size())},
                       {"num_models", static_cast<double>(proposals->models.size())}}};
}

}  // namespace deepslam::stages
