#include "command_tree.h"

#include <regex>

#include <CLI/CLI.hpp>

namespace deepslam::tools {
namespace {

// CLI11 keeps choices and ranges only as text: "TEXT:{a,b}", "INT:INT in [0 - 1024]".
void ReadTypeName(const std::string& type, CommandOption& option) {
  option.value = type.substr(0, type.find(':'));
  std::smatch match;
  if (std::regex_search(type, match, std::regex(R"(\{([^}]*)\})"))) {
    std::string word;
    for (const char c : match[1].str() + ",") {
      if (c != ',') {
        word += c;
      } else {
        option.choices.push_back(word);
        word.clear();
      }
    }
  }
  if (std::regex_search(type, match, std::regex(R"(in \[([^\]]*)\])")))
    option.range = match[1].str();
}

CommandOption DescribeOption(const CLI::Option& option) {
  CommandOption described;
  described.description = option.get_description();
  described.required = option.get_required();
  described.default_text = option.get_default_str();
  described.repeatable = option.get_items_expected_max() > 1;
  if (option.nonpositional()) {
    for (const std::string& name : option.get_snames()) described.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) described.names.push_back("--" + name);
  } else {
    described.names.push_back(option.get_name(true));
  }
  if (option.get_type_size() != 0) ReadTypeName(option.get_type_name(), described);
  return described;
}

CommandNode Describe(const CLI::App& app, const std::vector<std::string>& path) {
  CommandNode node;
  node.path = path;
  node.description = app.get_description();
  for (const CLI::Option* option : app.get_options())
    (option->nonpositional() ? node.options : node.positionals).push_back(DescribeOption(*option));
  const auto shown = [](const CLI::App* command) { return !command->get_group().empty(); };
  for (const CLI::App* command : app.get_subcommands(shown)) {
    std::vector<std::string> below = path;
    below.push_back(command->get_name());
    node.commands.push_back(Describe(*command, below));
  }
  return node;
}

void Collect(const CommandNode& node, std::vector<const CommandNode*>& nodes) {
  nodes.push_back(&node);
  for (const CommandNode& command : node.commands) Collect(command, nodes);
}

}  // namespace

CommandNode DescribeCommands(const CLI::App& app) { return Describe(app, {}); }

std::vector<const CommandNode*> AllCommands(const CommandNode& root) {
  std::vector<const CommandNode*> nodes;
  Collect(root, nodes);
  return nodes;
}

std::string PathText(const CommandNode& node) {
  std::string text;
  for (const std::string& name : node.path) text += (text.empty() ? "" : " ") + name;
  return text;
}

}  // namespace deepslam::tools
