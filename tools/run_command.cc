#include <unistd.h>
#include <cstdio>
#include <memory>
#include <span>
#include <tuple>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "commands.h"
#include "console.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/utf8.h"
#include "deepslam/pipeline/runner.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/plan.h"
#include "deepslam/storage/store.h"
#include "run_capture.h"

namespace deepslam::tools {
namespace {

using artifact::JsonArray;
using artifact::JsonObject;
using artifact::JsonValue;

struct RunArguments {
  std::string capture;
  std::string workspace;
  ConfigSources config;
  std::string poses;
  std::string until;
  std::vector<std::string> force;
  bool explain = false;
  int threads = 0;
  std::string progress = "auto";
  std::string data;
  std::string overrides;
};

JsonValue Strings(std::span<const std::string> strings) {
  JsonArray array;
  for (const std::string& string : strings) array.emplace_back(string);
  return JsonValue(std::move(array));
}

Status TellResult(const pipeline::RunReport& report, const std::filesystem::path& workspace) {
  JsonObject document = artifact::NewDocument("deepslam/run_result", 1);
  document.emplace("ran", Strings(report.ran));
  document.emplace("skipped", Strings(report.skipped));
  // A run that ends before leaves what an earlier one made, which may be of other options.
  for (const auto& [name, stage, file] : {std::tuple("scene", "export", "scene.glb"),
                                          std::tuple("map", "export", "map.json"),
                                          std::tuple("report", "report", "index.html")}) {
    const std::filesystem::path path = workspace / stage / file;
    if (!Stands(report, stage) || !std::filesystem::exists(path)) continue;
    const std::string told = ToValidUtf8(path.string());
    document.emplace(name, told);
    LogInfo(fmt::format("{:<9} {}", name, told));
  }
  const Result<std::string> text = DumpJson(std::move(document), "result");
  if (!text.ok()) return text.error();
  return ::isatty(STDOUT_FILENO) != 0 ? Ok() : WriteResult("", *text);
}

int Run(const RunArguments& arguments) {
  if (arguments.workspace.empty())
    return ReportError(InvalidConfig("--output: names no folder; give the workspace's"));
  ConfigSources sources = arguments.config;
  if (!arguments.poses.empty()) sources.settings.push_back("track.poses=" + arguments.poses);
  const Result<stages::Config> config = ReadConfig(sources);
  if (!config.ok()) return ReportError(config.error());

  CatchStopSignals();
  const ThreadLimit limit(arguments.threads);
  CaptureRun run;
  run.capture = arguments.capture;
  run.workspace = arguments.workspace;
  run.data_folder = stages::FindDataFolder(arguments.data);
  run.until = arguments.until;
  run.force = {arguments.force.begin(), arguments.force.end()};
  run.overrides = arguments.overrides;
  ConsoleListener listener(ParseProgressStyle(arguments.progress), arguments.explain);
  const Result<CaptureRunResult> result = RunCapture(run, *config, listener);
  if (!result.ok()) return ReportError(result.error());
  const Status status = TellResult(result->report, arguments.workspace);
  return status.ok() ? kExitOk : ReportError(status.error());
}

std::string_view NameOf(pipeline::StageState state) {
  switch (state) {
    case pipeline::StageState::kDone:
      return "done";
    case pipeline::StageState::kDropped:
      return "dropped";
    case pipeline::StageState::kStale:
      return "stale";
    case pipeline::StageState::kMissing:
      break;
  }
  return "missing";
}

JsonValue ToJson(const pipeline::StageReport& report) {
  JsonObject row;
  row.emplace("stage", report.name);
  row.emplace("state", NameOf(report.state));
  row.emplace("reasons", Strings(report.reasons));
  row.emplace("summary", report.summary);
  row.emplace("bytes", static_cast<std::int64_t>(report.num_bytes));
  row.emplace("wall_s", report.timing.wall_s);
  row.emplace("cpu_s", report.timing.cpu_s);
  row.emplace("peak_memory_mib", report.timing.peak_memory_mib);
  return JsonValue(std::move(row));
}

int ShowStatus(const std::string& workspace) {
  stages::Config config;
  if (const Result<std::string> record =
          storage::ReadFile(std::filesystem::path(workspace) / kRunFile);
      record.ok()) {
    Result<stages::Config> decoded = DecodeRun(*record);
    if (decoded.ok()) {
      config = std::move(decoded).value();
    } else {
      LogWarning(
          fmt::format("{}/{}; options are taken for the defaults, the next run writes it anew",
                      workspace,
                      decoded.error().message));
    }
  }
  stages::RunInputs inputs{config, {}, nullptr, {}};
  std::span<const std::string_view> looked_at;
  if (std::filesystem::exists(std::filesystem::path(workspace) / kOverridesFile)) {
    const Result<Overrides> overrides = ReadOverrides(workspace, {});
    if (!overrides.ok()) return ReportError(overrides.error());
    inputs.overrides = *overrides;
    looked_at = stages::kOverrideInputs;
  }
  const auto reports = pipeline::InspectWorkspace(
      stages::MakePlan(std::make_shared<const stages::RunInputs>(inputs)), workspace, looked_at);
  if (!reports.ok()) return ReportError(reports.error());
  JsonArray rows;
  for (const pipeline::StageReport& report : *reports) {
    rows.push_back(ToJson(report));
    std::string text = report.summary;
    for (const std::string& reason : report.reasons) text += (text.empty() ? "" : "; ") + reason;
    fmt::print(stderr,
               "{:<9} {:<7} {:8.1f} s {:8.1f} MiB {:8.2f} MB  {}\n",
               report.name,
               NameOf(report.state),
               report.timing.wall_s,
               report.timing.peak_memory_mib,
               static_cast<double>(report.num_bytes) / 1e6,
               text);
  }
  if (::isatty(STDOUT_FILENO) != 0) return kExitOk;
  JsonObject document = artifact::NewDocument("deepslam/status", 1);
  document.emplace("stages", std::move(rows));
  const Result<std::string> text = DumpJson(std::move(document), "status");
  const Status status = text.ok() ? WriteResult("", *text) : Status(text.error());
  return status.ok() ? kExitOk : ReportError(status.error());
}

}  // namespace

void AddRun(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* run = app.add_subcommand(
      "run", "From a capture to a labelled scene; continues where an earlier run stopped");
  run->add_option(
         "CAPTURE", arguments->capture, "Capture: a folder (docs/formats.md) or a .sens file")
      ->required();
  run->add_option(
         "-o,--output", arguments->workspace, "Workspace folder: all results, one folder per stage")
      ->required();
  AddConfigOptions(*run, arguments->config);
  run->add_option(
         "--poses",
         arguments->poses,
         "track: estimate camera poses; capture: use those of the capture; prior: start from "
         "them")
      ->check(CLI::IsMember({"track", "capture", "prior"}));
  run->add_option("--overrides",
                  arguments->overrides,
                  "Corrections by hand (YAML); default: overrides.yaml of the workspace");
  run->add_option("--until", arguments->until, "Last stage to run");
  run->add_option(
         "--force", arguments->force, "Run this stage although its files stand; may be repeated")
      ->expected(1)
      ->take_all();
  run->add_flag("--explain", arguments->explain, "Say why each stage runs or not");
  run->add_option("--threads",
                  arguments->threads,
                  "Worker threads, 0 = all cores; results do not depend on it")
      ->check(CLI::Range(0, 1024));
  run->add_option("--progress", arguments->progress, "auto, bar, json or none")
      ->check(CLI::IsMember({"auto", "bar", "json", "none"}))
      ->capture_default_str();
  run->add_option("--data",
                  arguments->data,
                  "Folder of weights and furniture library (default: see `deepslam doctor`)");
  run->callback([&chosen, arguments] { chosen = [arguments] { return Run(*arguments); }; });
}

void AddStatus(CLI::App& app, Command& chosen) {
  auto workspace = std::make_shared<std::string>();
  CLI::App* status = app.add_subcommand(
      "status", "Stages of a workspace: done, stale and why, missing; sizes and times");
  status->add_option("WORKSPACE", *workspace, "Workspace folder")->required();
  status->callback(
      [&chosen, workspace] { chosen = [workspace] { return ShowStatus(*workspace); }; });
}

}  // namespace deepslam::tools
