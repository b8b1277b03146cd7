// propose: whole shapes for every object, from every source that is switched on.
#include <algorithm>
#include <array>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "deepslam/artifact/json_value.h"
#include "deepslam/artifact/proposals_json.h"
#include "deepslam/core/parallel.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/propose/level_cloud.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/load_priors.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/stage_inputs.h"
#include "deepslam/storage/store.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;
using pipeline::StageSummary;

struct Sources {
  std::vector<std::unique_ptr<propose::Proposer>> proposers;
  // Shared by the retrieval source and by this stage, which notes the checksums of the models
  // offered.
  std::shared_ptr<const ModelLibrary> library;
  bool use_depth = true;
};

Result<std::shared_ptr<const ModelLibrary>> LoadLibraryFolder(const std::filesystem::path& folder) {
  Result<ModelLibrary> library = library::LoadLibrary(folder);
  if (!library.ok()) return library.error();
  return std::make_shared<const ModelLibrary>(std::move(library).value());
}

Result<Sources> MakeSources(const RunInputs& inputs, Progress& progress) {
  const Config& config = inputs.config;
  const bool use_depth = config.propose_stage.use_depth;
  Sources sources;
  sources.use_depth = use_depth;
  if (config.propose_stage.retrieval) {
    const Result<std::filesystem::path> folder =
        FindLibrary(inputs.data_folder, config.propose_stage.library);
    if (!folder.ok()) return folder.error();
    Result<std::shared_ptr<const ModelLibrary>> library =
        inputs.models ? inputs.models->Library(*folder) : LoadLibraryFolder(*folder);
    if (!library.ok()) return library.error();
    sources.library = std::move(library).value();
    sources.proposers.push_back(propose::MakeRetrievalProposer(
        sources.library,
        inputs.classes,
        config.retrieval,
        use_depth ? propose::Sight::kColourAndDepth : propose::Sight::kColour));
  }
  if (config.propose_stage.fused && use_depth) {
    sources.proposers.push_back(propose::MakeFusedProposer(inputs.classes, config.fused));
  }
  if (config.propose_stage.network) {
    const auto priors = PriorsOf(inputs);
    if (!priors.ok()) return priors.error();
    if (!*priors) {
      progress.Warn(
          "no shape networks are there; shapes come from the other sources alone "
          "(propose.priors names a folder with networks)");
      return sources;
    }
    sources.proposers.push_back(propose::MakeNetworkProposer(
        **priors,
        inputs.classes,
        config.shape_network,
        use_depth ? propose::Sight::kColourAndDepth : propose::Sight::kColour));
  }
  return sources;
}

// What all sources say of one object, in their order. Candidates have no numbers yet.
Result<Proposals> ProposeOne(const Sources& sources, const TrackViews& of_track) {
  const ObjectTrack& track = *of_track.track;
  const std::string name = fmt::format("{}_{:02d}", track.class_name, track.id.value);
  Proposals all;
  if (of_track.views.empty()) {
    all.notes.push_back(name + ": no view could be read");
    return all;
  }
  propose::ObjectObservations object{track.id, track.class_name, of_track.views};
  std::optional<propose::LevelCloud> cloud;
  if (sources.use_depth) {
    cloud = propose::AccumulateLevel(object.views);
    object.cloud = &*cloud;
  }
  const std::size_t num_sources = sources.proposers.size();
  std::vector<std::optional<Result<Proposals>>> answers(num_sources);
  ParallelFor(num_sources,
              [&](std::size_t s) { answers[s] = sources.proposers[s]->Propose(object); });
  for (std::size_t s = 0; s < num_sources; ++s) {
    if (!answers[s]->ok()) {
      return Error{
          answers[s]->error().code,
          fmt::format("source {}: {}", sources.proposers[s]->name(), answers[s]->error().message)};
    }
    Proposals answer = std::move(*answers[s]).value();
    for (std::string& note : answer.notes) note = fmt::format("{}: {}", name, note);
    Join(std::move(answer), all);
  }
  return all;
}

Result<Proposals> ProposeAll(const StageContext& context,
                             const RunInputs& inputs,
                             const Sources& sources,
                             const Trajectory& trajectory,
                             const Ground& ground,
                             const Association& association) {
  Proposals all;
  const auto append = [&](const TrackViews&, Proposals of_object) {
    auto next_id = static_cast<int>(all.candidates.size());
    for (ShapeCandidate& candidate : of_object.candidates) candidate.id = CandidateId{next_id++};
    Join(std::move(of_object), all);
    return Ok();
  };
  const Status status = ForEachTrackViews<Proposals>(
      context,
      inputs,
      trajectory,
      ground,
      association.tracks,
      observe::ViewContent::kColourAndDepth,
      [&](const TrackViews& of_track) { return ProposeOne(sources, of_track); },
      append);
  if (!status.ok()) return status.error();
  return all;
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
  const Result<Sources> sources = MakeSources(inputs, context.progress());
  if (!sources.ok()) return sources.error();
  const Result<Proposals> proposals =
      ProposeAll(context, inputs, *sources, *trajectory, *ground, *association);
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
