#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "commands.h"
#include "eval_commands.h"
#include "eval_silhouettes.h"

namespace deepslam::tools {
namespace {

void AddEvalSilhouettes(CLI::App& eval_command, Command& chosen) {
  struct Arguments {
    std::string workspace;
    std::string capture;
    std::string json;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* silhouettes = eval_command.add_subcommand(
      "silhouettes", "Overlap of the projected objects with what was segmented; needs no truth");
  silhouettes->add_option("WORKSPACE", arguments->workspace, "Workspace of a finished run")
      ->required();
  silhouettes->add_option("CAPTURE", arguments->capture, "The capture it was made of")->required();
  silhouettes->add_option(
      "--json", arguments->json, "Write the result here instead of to standard output");
  silhouettes->callback([&chosen, arguments] {
    chosen = [arguments] {
      return EvalSilhouettes(arguments->workspace, arguments->capture, arguments->json);
    };
  });
}

}  // namespace

void AddEval(CLI::App& app, Command& chosen) {
  CLI::App* eval_command = app.add_subcommand("eval", "Compare results with the truth");
  eval_command->require_subcommand(1);
  AddEvalTrajectory(*eval_command, chosen);
  AddEvalDetections(*eval_command, chosen);
  AddEvalObjects(*eval_command, chosen);
  AddEvalSelection(*eval_command, chosen);
  AddEvalLayout(*eval_command, chosen);
  AddEvalMap(*eval_command, chosen);
  AddEvalSilhouettes(*eval_command, chosen);
}

}  // namespace deepslam::tools
