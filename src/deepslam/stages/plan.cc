#include "deepslam/stages/plan.h"

#include <filesystem>
#include <optional>
#include <utility>

#include "deepslam/artifact/class_table_yaml.h"
#include "deepslam/artifact/overrides_yaml.h"
#include "deepslam/core/sha256.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/storage/store.h"

namespace deepslam::stages {
namespace {

using pipeline::Stage;
using pipeline::StageContext;
using pipeline::StageSummary;
using StringMap = std::map<std::string, std::string>;
using StageFunction = Result<StageSummary> (*)(StageContext&, const RunInputs&);

// What a stage takes from outside the workspace.
enum External : unsigned {
  kNothing = 0,
  kFrames = 1,
  kClasses = 2,
  kDetector = 4,
  kLibrary = 8,
  // parts of overrides.yaml
  kGroundHint = 16,
  kTrackOverrides = 32,
  kChoices = 64,
  kPriors = 128,
};

// What lies at a place enters a key by its content.
Status AddContent(const RunInputs& inputs,
                  const std::string& key,
                  const Result<std::filesystem::path>& place,
                  StringMap& hashes) {
  if (!place.ok()) return place.error();
  const Result<std::string> hash =
      inputs.hashes ? inputs.hashes->Of(*place) : ContentHashes().Of(*place);
  if (!hash.ok()) return hash.error();
  hashes.emplace(key, *hash);
  return Ok();
}

Status AddDetector(const RunInputs& inputs, StringMap& hashes) {
  const DetectStageOptions& options = inputs.config.detect_stage;
  if (options.source == "none") return Ok();
  if (options.source == "network") {
    const Result<std::filesystem::path> file = FindWeights(inputs.data_folder, options.weights);
    return AddContent(inputs, "weights", file, hashes);
  }
  if (options.file.empty())
    return InvalidConfig("detect.source is file, but detect.file names none");
  return AddContent(inputs, "coco_file", std::filesystem::path(options.file), hashes);
}

Status AddLibrary(const RunInputs& inputs, StringMap& hashes) {
  const ProposeStageOptions& options = inputs.config.propose_stage;
  if (!options.retrieval) return Ok();
  const Result<std::filesystem::path> folder = FindLibrary(inputs.data_folder, options.library);
  return AddContent(inputs, "library", folder, hashes);
}

Status AddPriors(const RunInputs& inputs, StringMap& hashes) {
  const ProposeStageOptions& options = inputs.config.propose_stage;
  if (!options.network) return Ok();
  const auto folder = FindPriors(inputs.data_folder, options.priors);
  if (!folder.ok()) return folder.error();
  if (!*folder) return Ok();
  return AddContent(inputs, "priors", **folder, hashes);
}

Result<StringMap> Externals(const RunInputs& inputs, unsigned what) {
  StringMap hashes;
  if ((what & kFrames) != 0 && inputs.capture)
    hashes.emplace("capture", inputs.capture->content_hash);
  if ((what & kClasses) != 0)
    hashes.emplace("classes", Sha256Hex(artifact::EncodeClassTable(inputs.classes)));
  if ((what & kDetector) != 0) {
    if (Status status = AddDetector(inputs, hashes); !status.ok()) return status.error();
  }
  if ((what & kLibrary) != 0) {
    if (Status status = AddLibrary(inputs, hashes); !status.ok()) return status.error();
  }
  if ((what & kPriors) != 0) {
    if (Status status = AddPriors(inputs, hashes); !status.ok()) return status.error();
  }
  // What is not overridden leaves no trace: an empty file is as good as none.
  const auto add = [&](unsigned part, std::string_view name, const std::string& text) {
    if ((what & part) != 0 && !text.empty()) hashes.emplace(name, Sha256Hex(text));
  };
  add(kGroundHint, kOverrideInputs[0], artifact::GroundOverridesText(inputs.overrides));
  add(kTrackOverrides, kOverrideInputs[1], artifact::TrackOverridesText(inputs.overrides));
  add(kChoices, kOverrideInputs[2], artifact::ChoiceOverridesText(inputs.overrides));
  return hashes;
}

// What a stage made while the machine did not give it all frames is nobody's result: it would pass
// for the capture's in every later run.
Result<StageSummary> RunOn(StageContext& context, const RunInputs& inputs, StageFunction function) {
  Result<StageSummary> summary = function(context, inputs);
  const bool stopped = !summary.ok() && summary.error().code == ErrorCode::kInterrupted;
  if (stopped || !inputs.capture || !inputs.capture->faults) return summary;
  if (const std::optional<Error> fault = inputs.capture->faults->first()) return *fault;
  return summary;
}

}  // namespace

Result<ClassTable> LoadClasses(const Config& config) {
  if (config.classes_file.empty()) return artifact::DefaultClassTable();
  const Result<std::string> text = storage::ReadFile(config.classes_file);
  if (!text.ok()) return Error{ErrorCode::kInvalidConfig, "classes.file: " + text.error().message};
  return artifact::DecodeClassTable(*text, config.classes_file);
}

void HashModels(const RunInputs& inputs) {
  for (const unsigned what : {kDetector, kLibrary, kPriors})
    static_cast<void>(Externals(inputs, what));
}

std::vector<Stage> MakePlan(SharedInputs inputs) {
  std::vector<Stage> stages;
  const auto add = [&](std::string name,
                       int version,
                       std::vector<std::string> stage_inputs,
                       const std::set<std::string>& sections,
                       unsigned externals,
                       StageFunction function) {
    stages.push_back(
        {std::move(name),
         version,
         std::move(stage_inputs),
         KeyOptions(inputs->config, sections),
         [inputs, externals] { return Externals(*inputs, externals); },
         [inputs, function](StageContext& context) { return RunOn(context, *inputs, function); }});
  };
  // Versions rise whenever results may differ with equal options.
  add("track", 18, {}, {"track", "track.covisible"}, kFrames, RunTrack);
  add("ground", 6, {"track"}, {"ground"}, kFrames | kGroundHint, RunGround);
  add("detect",
      7,
      {"track", "ground"},
      {"detect", "detect.network", "detect.clusters"},
      kFrames | kClasses | kDetector,
      RunDetect);
  add("segment", 7, {"track", "ground", "detect"}, {"segment"}, kFrames, RunSegment);
  add("associate", 7, {"track", "segment"}, {"associate"}, kFrames | kTrackOverrides, RunAssociate);
  add("propose",
      8,
      {"track", "ground", "segment", "associate"},
      {"views", "propose", "propose.retrieval", "propose.measured", "propose.networks"},
      kFrames | kClasses | kLibrary | kPriors,
      RunPropose);
  add("register",
      7,
      {"track", "ground", "segment", "associate", "propose"},
      {"views", "register"},
      kFrames,
      RunRegister);
  add("select",
      17,
      {"track", "ground", "segment", "associate", "propose", "register"},
      {"views", "register", "select", "select.refine"},
      kFrames | kChoices | kPriors,
      RunSelect);
  add("loops",
      28,
      {"track", "ground", "segment", "associate", "propose", "register", "select"},
      {"track",
       "views",
       "register",
       "select",
       "select.refine",
       "loops",
       "loops.appearance",
       "optimize"},
      kFrames | kChoices,
      RunLoops);
  add("optimize", 4, {"track", "ground", "loops"}, {"optimize"}, kNothing, RunOptimize);
  add("mesh",
      2,
      {"track", "ground", "segment", "loops", "optimize"},
      {"views", "mesh.surface", "mesh.refine", "mesh.colour"},
      kFrames | kClasses,
      RunMesh);
  add("fuse", 5, {"detect", "segment", "loops", "optimize"}, {"fuse"}, kFrames, RunFuse);
  add("export",
      10,
      {"track", "propose", "select", "loops", "optimize", "mesh", "fuse"},
      {"export", "export.ground", "export.gltf"},
      kFrames | kClasses,
      RunExport);
  add("report",
      11,
      {"track",
       "ground",
       "detect",
       "segment",
       "associate",
       "propose",
       "register",
       "select",
       "loops",
       "optimize",
       "mesh",
       "fuse",
       "export"},
      {},
      kFrames | kClasses,
      RunReport);
  return stages;
}

}  // namespace deepslam::stages
