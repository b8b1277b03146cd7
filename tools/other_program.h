// Commands of `deepslam` that the program beside it does, `deepslam-tools`: whoever maps captures
// need not load what renders worlds and scores maps.
#pragma once

#include <span>

#include "commands.h"

namespace deepslam::tools {

// Whether these arguments, without the program's name, ask for such a command, or for the help of
// all commands.
[[nodiscard]] bool IsForOtherProgram(std::span<const char* const> arguments);

// Becomes that program, with the same arguments; returns, with an exit code, only where it cannot
// be started, and says why.
[[nodiscard]] int StartOtherProgram(char** argv);

// Its commands in the help of this one.
void NameOtherCommands(CLI::App& app, Command& chosen);

}  // namespace deepslam::tools
