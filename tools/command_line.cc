#include "command_line.h"

#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "console.h"
#include "deepslam/core/freed_memory.h"
#include "deepslam/core/nearest_word.h"

namespace deepslam::tools {
namespace {

// A first word that is no command, told with the command it may be; nothing of all else.
std::string UnknownCommand(const CLI::App& app, std::string_view word) {
  if (word.starts_with('-')) return {};
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (command->check_name(std::string(word))) return {};
    if (!command->get_group().empty()) known.push_back(command->get_name());
  }
  const std::string nearest = NearestWord(word, known);
  return fmt::format("{} is no command{}; 'deepslam --help' lists them",
                     word,
                     nearest.empty() ? nearest : fmt::format(", did you mean {}?", nearest));
}

}  // namespace

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
  if (const std::string fault = argc > 1 ? UnknownCommand(app, argv[1]) : std::string();
      !fault.empty()) {
    SetUpLogging(log_level);
    LogError(fault);
    return kExitUsage;
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

}  // namespace deepslam::tools
