// Texts made from the command line's own description: completions and the man page.
#include <memory>

#include <CLI/CLI.hpp>

#include "command_tree.h"
#include "commands.h"
#include "completion_script.h"
#include "deepslam/pipeline/config.h"
#include "deepslam/stages/plan.h"
#include "man_page.h"

namespace deepslam::tools {
namespace {

int Print(const std::string& text) {
  const Status status = WriteResult("", text);
  return status.ok() ? kExitOk : ReportError(status.error());
}

SettingWords ListSettings() {
  stages::Config config;
  SettingWords words;
  for (const pipeline::OptionEntry& option : pipeline::ListOptions(stages::Sections(config))) {
    words[option.name] = option.kind == pipeline::OptionKind::kFlag
                             ? std::vector<std::string>{"true", "false"}
                             : option.choices;
  }
  return words;
}

int PrintCompletion(const CommandNode& root, const std::string& shell) {
  const SettingWords settings = ListSettings();
  if (shell == "zsh") return Print(ZshCompletion(root, settings));
  if (shell == "fish") return Print(FishCompletion(root, settings));
  return Print(BashCompletion(root, settings));
}

}  // namespace

void AddForms(CLI::App& app, Command& chosen) {
  auto shell = std::make_shared<std::string>();
  CLI::App* completion = app.add_subcommand(
      "completion", "Print the completion of a shell: `source <(deepslam completion bash)`");
  completion->add_option("SHELL", *shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  completion->callback([&app, &chosen, shell] {
    chosen = [&app, shell] { return PrintCompletion(DescribeCommands(app), *shell); };
  });
  CLI::App* man = app.add_subcommand("man", "Print the man page: `deepslam man | man -l -`");
  man->callback([&app, &chosen] {
    chosen = [&app] { return Print(ManPage(DescribeCommands(app), stages::kToolVersion)); };
  });
}

}  // namespace deepslam::tools
