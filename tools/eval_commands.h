// Subcommands of `deepslam eval` with files of their own.
#pragma once

#include "commands.h"

namespace deepslam::tools {

void AddEvalTrajectory(CLI::App& eval_command, Command& chosen);
void AddEvalObjects(CLI::App& eval_command, Command& chosen);
void AddEvalSelection(CLI::App& eval_command, Command& chosen);
void AddEvalDetections(CLI::App& eval_command, Command& chosen);
void AddEvalLayout(CLI::App& eval_command, Command& chosen);
void AddEvalMap(CLI::App& eval_command, Command& chosen);

// `eval selection --held-out`: WORKSPACE CAPTURE pairs; one of them where a `scoring_workspace` is
// named, whose views score.
[[nodiscard]] int EvalHeldOut(const std::vector<std::string>& paths,
                              const std::string& scoring_workspace,
                              const std::string& json_file);

}  // namespace deepslam::tools
