#include <cstdio>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "commands.h"
#include "console.h"
#include "deepslam/class_table/class_table_yaml.h"
#include "deepslam/pipeline/config.h"
#include "deepslam/stages/plan.h"
#include "deepslam/storage/store.h"

namespace deepslam::tools {
namespace {

int Dump(const ConfigSources& sources) {
  Result<stages::Config> config = ReadConfig(sources);
  if (!config.ok()) return ReportError(config.error());
  const Status status = WriteResult("", pipeline::DumpConfig(stages::Sections(*config)));
  return status.ok() ? kExitOk : ReportError(status.error());
}

int Check(const ConfigSources& sources) {
  const Result<stages::Config> config = ReadConfig(sources);
  if (!config.ok()) return ReportError(config.error());
  const Result<ClassTable> classes = stages::LoadClasses(*config);
  if (!classes.ok()) return ReportError(classes.error());
  LogInfo("no faults");
  return kExitOk;
}

}  // namespace

int ExitCodeOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidConfig:
      return kExitUsage;
    case ErrorCode::kInvalidInput:
      return kExitInput;
    case ErrorCode::kInterrupted:
      return kExitInterrupted;
    case ErrorCode::kFailed:
      break;
  }
  return kExitFailed;
}

int ReportError(const Error& error) {
  LogError(error.message);
  return ExitCodeOf(error.code);
}

void AddConfigOptions(CLI::App& command, ConfigSources& sources) {
  command
      .add_option("--config",
                  sources.files,
                  "YAML file of options that differ from the defaults; may be repeated")
      ->expected(1)
      ->take_all();
  command
      .add_option("--set",
                  sources.settings,
                  "One option, NAME=VALUE; may be repeated, comes after --config")
      ->expected(1)
      ->take_all();
}

Result<stages::Config> ReadConfig(const ConfigSources& sources) {
  stages::Config config;
  const std::vector<pipeline::OptionSection> sections = stages::Sections(config);
  std::string faults;
  const auto note = [&](const Status& status) {
    if (!status.ok()) faults += (faults.empty() ? "" : "\n") + status.error().message;
  };
  for (const std::string& file : sources.files) {
    const Result<std::string> text = storage::ReadFile(file);
    note(text.ok() ? pipeline::ApplyYaml(sections, *text, file) : Status(text.error()));
  }
  note(pipeline::ApplySettings(sections, sources.settings));
  if (!faults.empty()) return InvalidConfig(faults);
  return config;
}

Status WriteResult(const std::string& file, const std::string& text) {
  if (!file.empty()) return storage::WriteFileAtomically(file, text);
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    return Failed("standard output: cannot write");
  }
  return Ok();
}

void AddConfig(CLI::App& app, Command& chosen) {
  CLI::App* config = app.add_subcommand("config", "Show or check options");
  config->require_subcommand(1);
  auto sources = std::make_shared<ConfigSources>();
  CLI::App* dump =
      config->add_subcommand("dump", "All options with value, range, unit and meaning, as YAML");
  AddConfigOptions(*dump, *sources);
  dump->callback([&chosen, sources] { chosen = [sources] { return Dump(*sources); }; });
  CLI::App* check =
      config->add_subcommand("check", "Check configuration files; tells all faults at once");
  check->add_option("FILE", sources->files, "YAML files, later ones over earlier ones")->required();
  check->callback([&chosen, sources] { chosen = [sources] { return Check(*sources); }; });
  CLI::App* classes = config->add_subcommand("classes", "The table of object classes, as YAML");
  classes->callback([&chosen] {
    chosen = [] {
      const Status status =
          WriteResult("", class_table::EncodeClassTable(class_table::DefaultClassTable()));
      return status.ok() ? kExitOk : ReportError(status.error());
    };
  });
}

void AddVersion(CLI::App& app, Command& chosen) {
  app.add_subcommand("version", "Print the version")->callback([&chosen] {
    chosen = [] {
      fmt::print("deepslam {}\n", stages::kToolVersion);
      return kExitOk;
    };
  });
}

}  // namespace deepslam::tools
