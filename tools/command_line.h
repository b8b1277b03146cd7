// What all programs of deepslam do with their command line.
#pragma once

#include <span>

#include "commands.h"

namespace deepslam::tools {

using AddCommand = void (*)(CLI::App& app, Command& chosen);

// Parses the arguments by the commands there are and does the one that is asked for. The exit code.
[[nodiscard]] int RunCommandLine(int argc, char** argv, std::span<const AddCommand> commands);

}  // namespace deepslam::tools
