#include "other_program.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kProgram = "deepslam-tools";

struct OtherCommand {
  std::string_view name;
  std::string_view description;
};
constexpr std::array<OtherCommand, 5> kCommands = {{
    {"eval", "Compare results with the truth"},
    {"synth", "Render a capture with truth from a scene file"},
    {"priors", "Training data of the shape networks, and a look at what they propose"},
    {"completion", "Print the completion of a shell: `source <(deepslam completion bash)`"},
    {"man", "Print the man page: `deepslam man | man -l -`"},
}};

}  // namespace

bool IsForOtherProgram(std::span<const char* const> arguments) {
  for (std::size_t n = 0; n < arguments.size(); ++n) {
    const std::string_view word = arguments[n];
    if (word == "--help-all") return true;
    if (word == "--log-level") ++n;  // its value is no command
    if (word.starts_with('-')) continue;
    return std::ranges::any_of(kCommands, [&](const OtherCommand& c) { return c.name == word; });
  }
  return false;
}

int StartOtherProgram(char** argv) {
  std::error_code error;
  const fs::path own = fs::read_symlink("/proc/self/exe", error);
  const fs::path other = own.parent_path() / kProgram;
  execv(other.c_str(), argv);
  return ReportError(Failed(
      fmt::format("{} cannot be started ({}): it belongs beside {}; build or install deepslam anew",
                  other.string(),
                  std::strerror(errno),
                  own.filename().string())));
}

void NameOtherCommands(CLI::App& app, Command&) {
  for (const OtherCommand& command : kCommands)
    app.add_subcommand(std::string(command.name), std::string(command.description));
}

}  // namespace deepslam::tools
