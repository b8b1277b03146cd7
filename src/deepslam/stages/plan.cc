#include "deepslam/stages/plan.h"

#include <array>
#include <filesystem>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "deepslam/class_table/class_table_yaml.h"
#include "deepslam/stages/external_inputs.h"
#include "deepslam/storage/store.h"

namespace deepslam::stages {
namespace {

using pipeline::Stage;
using pipeline::StageContext;
using pipeline::StageSummary;
using StageFunction = Result<StageSummary> (*)(StageContext&, const RunInputs&);

struct PlannedStage {
  std::string_view name;
  int version;                // rises whenever results may differ with equal options
  std::string_view inputs;    // names of stages ...
  std::string_view sections;  // ... and of the configuration's sections, spaces between
  unsigned externals;
  StageFunction run;
};

constexpr std::array<PlannedStage, 15> kChain = {{
    {"track", 22, "", "track track.covisible track.join", kFrames, RunTrack},
    {"ground", 8, "track", "ground", kFrames | kGroundHint, RunGround},
    {"layout", 14, "track ground", "layout layout.surface", kFrames, RunLayout},
    {"detect",
     13,
     "track ground",
     "detect detect.network detect.clusters",
     kFrames | kClasses | kDetector,
     RunDetect},
    {"segment", 7, "track ground detect", "segment", kFrames | kClasses, RunSegment},
    {"associate",
     23,
     "track ground layout detect segment",
     "associate associate.things",
     kFrames | kClasses | kTrackOverrides,
     RunAssociate},
    {"propose",
     18,
     "track ground layout associate",
     "views propose propose.retrieval propose.measured propose.networks",
     kFrames | kClasses | kLibrary | kPriors,
     RunPropose},
    {"register",
     12,
     "track ground layout associate propose",
     "views register",
     kFrames | kClasses,
     RunRegister},
    {"select",
     31,
     "track ground layout associate propose register",
     "views register select select.refine",
     kFrames | kClasses | kChoices | kPriors,
     RunSelect},
    {"loops",
     42,
     "track ground layout associate propose register select",
     "track views register select select.refine loops loops.appearance optimize",
     kFrames | kClasses | kChoices,
     RunLoops},
    {"optimize", 6, "track ground layout loops", "optimize", kFrames | kClasses, RunOptimize},
    {"mesh",
     3,
     "track ground associate loops optimize",
     "views mesh.surface mesh.refine mesh.colour",
     kFrames | kClasses,
     RunMesh},
    {"fuse", 6, "detect associate loops optimize", "fuse", kFrames, RunFuse},
    {"export",
     15,
     "track ground layout detect propose select loops optimize mesh fuse",
     "export export.ground export.gltf export.convex",
     kFrames | kClasses | kExportColumns,
     RunExport},
    {"report",
     14,
     "track ground layout detect segment associate propose register select loops optimize "
     "mesh fuse export",
     "",
     kFrames | kClasses,
     RunReport},
}};

std::vector<std::string> Words(std::string_view text) {
  std::istringstream words{std::string(text)};
  return {std::istream_iterator<std::string>(words), {}};
}

// A folder that is moved away takes frames along that this run has not read yet.
Status IsStillThere(const std::filesystem::path& capture) {
  std::error_code error;
  if (std::filesystem::exists(capture, error)) return Ok();
  return Failed(fmt::format("{}: is gone since the run began; bring it back and run again",
                            capture.string()));
}

// What a stage made while the machine did not give it all frames is nobody's result: it would pass
// for the capture's in every later run.
Result<StageSummary> RunOn(StageContext& context, const RunInputs& inputs, StageFunction function) {
  Result<StageSummary> summary = function(context, inputs);
  const bool stopped = !summary.ok() && summary.error().code == ErrorCode::kInterrupted;
  if (stopped || !inputs.capture || !inputs.capture->faults) return summary;
  if (const std::optional<Error> fault = inputs.capture->faults->first()) return *fault;
  if (Status status = IsStillThere(inputs.capture->path); !status.ok()) return status.error();
  return summary;
}

}  // namespace

Result<ClassTable> LoadClasses(const Config& config) {
  if (config.classes_file.empty()) return class_table::DefaultClassTable();
  const Result<std::string> text = storage::ReadFile(config.classes_file);
  if (!text.ok()) return Error{ErrorCode::kInvalidConfig, "classes.file: " + text.error().message};
  return class_table::DecodeClassTable(*text, config.classes_file);
}

std::vector<Stage> MakePlan(SharedInputs inputs) {
  std::vector<Stage> stages;
  for (const PlannedStage& planned : kChain) {
    const std::vector<std::string> sections = Words(planned.sections);
    stages.push_back({std::string(planned.name),
                      planned.version,
                      Words(planned.inputs),
                      KeyOptions(inputs->config, {sections.begin(), sections.end()}),
                      [inputs, &planned] { return HashExternals(*inputs, planned.externals); },
                      [inputs, &planned](StageContext& context) {
                        return RunOn(context, *inputs, planned.run);
                      }});
  }
  return stages;
}

}  // namespace deepslam::stages
