#include "run_capture.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "console.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/core/parallel.h"
#include "deepslam/dataset/kept_frames.h"
#include "deepslam/layouts/open_capture.h"
#include "deepslam/modelling/prepared_models.h"
#include "deepslam/pipeline/config.h"
#include "deepslam/stages/plan.h"
#include "deepslam/storage/store.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using artifact::JsonArray;
using artifact::JsonObject;

constexpr std::string_view kTimingPage = "timing.html";
constexpr std::string_view kRunFormat = "deepslam/run";
constexpr int kRunVersion = 1;  // rises with every change of the file
// Decoded images that stay in memory: of 640 x 480 px 700 depth images, or 145 of colour. The
// longer a capture, the less of it they are, and the more memory its poses and masks take: beyond
// so many frames they are fewer.
constexpr std::size_t kKeptFrameBytes = std::size_t{128} << 20;
constexpr std::size_t kFramesWithAllKept = 3000;  // longer captures keep fewer, in proportion
// And 60 models, of four or five objects.
constexpr std::size_t kPreparedModelBytes = std::size_t{96} << 20;

std::size_t KeptFrameBytes(int num_frames) {
  const std::size_t times = std::max(kFramesWithAllKept, static_cast<std::size_t>(num_frames));
  return kKeptFrameBytes * kFramesWithAllKept / times;
}

// timing.html beside the report, which opens it in a hidden frame and is told the times: they are
// no part of any artifact, and a page that was copied away goes without them.
Status WriteTimingPage(std::span<const pipeline::StageTiming> timings,
                       const pipeline::RunReport& report,
                       const fs::path& workspace) {
  JsonArray rows;
  for (const pipeline::StageTiming& timing : timings) {
    JsonObject row;
    row.emplace("stage", timing.name);
    row.emplace("wall_s", timing.timing.wall_s);
    row.emplace("cpu_s", timing.timing.cpu_s);
    row.emplace("peak_mb", timing.timing.peak_memory_mib);
    row.emplace("reused",
                std::find(report.ran.begin(), report.ran.end(), timing.name) == report.ran.end());
    rows.emplace_back(std::move(row));
  }
  const Result<std::string> json = DumpJson(std::move(rows), kTimingPage);
  if (!json.ok()) return json.error();
  return storage::WriteFileAtomically(workspace / kTimingPage,
                                      "<!DOCTYPE html><meta charset=utf-8><title>times</title>"
                                      "<script>\nparent.postMessage({deepslamTiming: " +
                                          *json + "}, '*');\n</script>\n");
}

// Opening waits for the disk and works by itself at times, in which models are hashed.
Result<dataset::Capture> OpenBesideModels(const fs::path& capture,
                                          const stages::RunInputs& inputs) {
  Result<dataset::Capture> opened = InvalidInput("");
  ParallelFor(2, [&](std::size_t n) {
    if (n == 0) {
      opened = layouts::OpenCapture(capture);
    } else {
      stages::HashModels(inputs);
    }
  });
  return opened;
}

}  // namespace

Result<Overrides> ReadOverrides(const fs::path& workspace, const fs::path& named) {
  fs::path file = named;
  if (file.empty()) {
    file = workspace / kOverridesFile;
    std::error_code error;
    if (!fs::exists(file, error)) return Overrides{};
  }
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  return artifact::DecodeOverrides(*text, file.filename().string());
}

bool Stands(const pipeline::RunReport& report, std::string_view stage) {
  return std::ranges::find(report.ran, stage) != report.ran.end() ||
         std::ranges::find(report.skipped, stage) != report.skipped.end();
}

// Options that differ from the defaults.
Result<std::string> EncodeRun(stages::Config config) {
  stages::Config defaults;
  std::map<std::string, std::string> default_values;
  for (const pipeline::OptionEntry& entry : pipeline::ListOptions(stages::Sections(defaults))) {
    default_values[entry.name] = entry.value;
  }
  JsonObject options;
  for (const pipeline::OptionEntry& entry : pipeline::ListOptions(stages::Sections(config))) {
    if (default_values[entry.name] != entry.value) options.emplace(entry.name, entry.value);
  }
  JsonObject document = artifact::NewDocument(kRunFormat, kRunVersion);
  document.emplace("options", std::move(options));
  return DumpJson(std::move(document), kRunFile);
}

Result<stages::Config> DecodeRun(std::string_view text) {
  artifact::JsonReader reader(text, kRunFile, kRunFormat, kRunVersion);
  std::map<std::string, std::string> values;
  for (const auto& [name, value] : reader.root()["options"].Members())
    values[name] = value.String();
  if (!reader.ok()) return reader.error();
  stages::Config config;
  if (Status status = pipeline::ApplyValues(stages::Sections(config), values, kRunFile);
      !status.ok()) {
    return status.error();
  }
  return config;
}

Result<CaptureRunResult> RunCapture(const CaptureRun& run,
                                    const stages::Config& config,
                                    pipeline::RunListener& listener) {
  const Result<ClassTable> classes = stages::LoadClasses(config);
  if (!classes.ok()) return classes.error();
  const Result<std::string> record = EncodeRun(config);
  if (!record.ok()) return record.error();
  const Result<Overrides> overrides = ReadOverrides(run.workspace, run.overrides);
  if (!overrides.ok()) return overrides.error();
  stages::RunInputs inputs{config, *classes, nullptr, run.data_folder, *overrides, run.models};
  inputs.hashes = run.hashes ? run.hashes : std::make_shared<stages::ContentHashes>();
  Result<dataset::Capture> opened = OpenBesideModels(run.capture, inputs);
  if (!opened.ok()) return opened.error();
  for (const std::string& warning : opened->warnings) LogWarning(warning);
  const std::size_t kept_bytes = KeptFrameBytes(opened->frames->num_frames());
  const double depth_units_per_m = opened->stored->cameras().depth_units_per_m;
  opened->frames = dataset::KeepFrames(std::move(opened->frames), depth_units_per_m, kept_bytes);
  const auto capture = std::make_shared<const dataset::Capture>(std::move(opened).value());
  inputs.capture = capture;
  inputs.prepared = std::make_shared<modelling::PreparedModels>(kPreparedModelBytes);
  const std::vector<pipeline::Stage> plan =
      stages::MakePlan(std::make_shared<const stages::RunInputs>(std::move(inputs)));
  pipeline::RunRequest request;
  request.workspace = run.workspace;
  request.until = run.until;
  request.force = run.force;
  request.keep = run.keep;
  request.lock_patience_s = run.lock_patience_s;
  request.notes = {{std::string(kRunFile), *record}};
  Result<pipeline::RunReport> report = pipeline::RunStages(plan, request, listener);
  if (!report.ok()) return report.error();
  std::vector<pipeline::StageTiming> timings = pipeline::ReadTimings(plan, run.workspace);
  if (Status status = WriteTimingPage(timings, *report, run.workspace); !status.ok())
    return status.error();
  return CaptureRunResult{std::move(report).value(), std::move(timings), capture};
}

}  // namespace deepslam::tools
