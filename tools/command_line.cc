#include "command_line.h"

#include <string>

#include <CLI/CLI.hpp>

#include "console.h"
#include "deepslam/core/freed_memory.h"

namespace deepslam::tools {

int RunCommandLine(int argc, char** argv, std::span<const AddCommand> commands) {
  KeepFreedMemory();
  CLI::App app("Labelled object maps from RGB-D captures", "deepslam");
  app.require_subcommand(1);
  app.set_help_all_flag("--help-all", "Help of all subcommands");
  std::string log_level = "info";
  app.add_option("--log-level", log_level, "What is told: error, warning, info or debug")
      ->check(CLI::IsMember({"error", "warning", "info", "debug"}))
      ->capture_default_str();
  app.fallthrough();
  Command chosen;
  for (const AddCommand add : commands) add(app, chosen);
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

}  // namespace deepslam::tools
