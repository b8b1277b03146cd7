// The command line as plain values, for the texts that are made from it: man page and completions.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace deepslam::tools {

struct CommandOption {
  std::vector<std::string> names;  // "-o", "--output"; of a positional its one name, "CAPTURE"
  std::string description;
  std::string value;                 // what is written for the value, "TEXT"; empty: takes none
  std::vector<std::string> choices;  // all values there are; empty: any
  std::string range;                 // "0 - 1024", or empty
  std::string default_text;          // or empty
  bool required = false;
  bool repeatable = false;  // positionals: several may be given
};

struct CommandNode {
  std::vector<std::string> path;  // {"eval", "objects"}; empty: the program itself
  std::string description;
  std::vector<CommandOption> positionals;
  std::vector<CommandOption> options;
  std::vector<CommandNode> commands;
};

// Hidden commands (those of the empty group) are left out.
[[nodiscard]] CommandNode DescribeCommands(const CLI::App& app);

// The node and all below it, in the order of the help.
[[nodiscard]] std::vector<const CommandNode*> AllCommands(const CommandNode& root);

// "eval objects".
[[nodiscard]] std::string PathText(const CommandNode& node);

}  // namespace deepslam::tools
