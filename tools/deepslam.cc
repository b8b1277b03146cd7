// `deepslam`: the command line. docs and design of the subcommands: README.md.
#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>

#include "commands.h"
#include "console.h"
#include "deepslam/core/freed_memory.h"

int main(int argc, char** argv) {
  using namespace deepslam::tools;  // NOLINT(google-build-using-namespace): the table below is all
                                    // of main
  deepslam::KeepFreedMemory();
  CLI::App app("Labelled object maps from RGB-D captures", "deepslam");
  app.require_subcommand(1);
  app.set_help_all_flag("--help-all", "Help of all subcommands");
  std::string log_level = "info";
  app.add_option("--log-level", log_level, "What is told: error, warning, info or debug")
      ->check(CLI::IsMember({"error", "warning", "info", "debug"}))
      ->capture_default_str();
  app.fallthrough();

  Command chosen;
  for (const auto add : {AddRun,
                         AddBatch,
                         AddBatchSummary,
                         AddBatchWorker,
                         AddStatus,
                         AddConfig,
                         AddDoctor,
                         AddValidate,
                         AddExpand,
                         AddConvert,
                         AddEval,
                         AddSynth,
                         AddLibrary,
                         AddForms,
                         AddPriors,
                         AddVersion}) {
    add(app, chosen);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    // Help goes to stdout and is no error; everything else is wrong usage.
    return app.exit(e) == 0 ? kExitOk : kExitUsage;
  }
  SetUpLogging(log_level);
  TurnFileSizeSignalIntoError();
  return chosen();
}
