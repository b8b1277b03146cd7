#include "completion_script.h"

#include <fmt/format.h>

namespace deepslam::tools {
namespace {

std::string Joined(const std::vector<std::string>& words, std::string_view separator) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += separator;
    text += word;
  }
  return text;
}

std::string Replaced(std::string_view text, char from, std::string_view to) {
  std::string out;
  for (const char c : text) {
    if (c == from) {
      out += to;
    } else {
      out += c;
    }
  }
  return out;
}

// Inside single quotes of bash and zsh.
std::string Quoted(const std::string& text) {
  return fmt::format("'{}'", Replaced(text, '\'', "'\\''"));
}

// Inside single quotes of fish.
std::string FishQuoted(const std::string& text) {
  return fmt::format("'{}'", Replaced(Replaced(text, '\\', "\\\\"), '\'', "\\'"));
}

std::vector<std::string> OptionNames(const CommandNode& node) {
  std::vector<std::string> names;
  for (const CommandOption& option : node.options)
    names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

std::vector<std::string> CommandNames(const CommandNode& node) {
  std::vector<std::string> names;
  for (const CommandNode& command : node.commands) names.push_back(command.path.back());
  return names;
}

// Patterns of `case` for "COMMAND OPTION" whose value may be any file, and lines for those whose
// values are known; bash and zsh share them.
struct ValueCases {
  std::string any;
  std::string known;
};

ValueCases CasesOf(const CommandNode& root, std::string_view offer) {
  ValueCases cases;
  for (const CommandNode* node : AllCommands(root)) {
    for (const CommandOption& option : node->options) {
      if (option.value.empty()) continue;
      std::vector<std::string> patterns;
      for (const std::string& name : option.names)
        patterns.push_back(fmt::format("'{} {}'", PathText(*node), name));
      const std::string pattern = Joined(patterns, " | ");
      if (option.choices.empty()) {
        if (!cases.any.empty()) cases.any += " | ";
        cases.any += pattern;
      } else {
        cases.known += fmt::format("    {}) {} ;;\n",
                                   pattern,
                                   fmt::format(fmt::runtime(offer), Joined(option.choices, " ")));
      }
    }
  }
  return cases;
}

std::string SettingNames(const SettingWords& settings) {
  std::vector<std::string> names;
  for (const auto& [name, values] : settings) names.push_back(name + "=");
  return Joined(names, " ");
}

std::string KnownPaths(const CommandNode& root) {
  std::vector<std::string> paths;
  for (const CommandNode* node : AllCommands(root)) {
    if (!node->path.empty()) paths.push_back(fmt::format("'{}'", PathText(*node)));
  }
  return Joined(paths, " | ");
}

}  // namespace

// Bash splits words at `=`: `--to=tum` arrives as three words, `--set a.b=c` as four.
std::string BashCompletion(const CommandNode& root, const SettingWords& settings) {
  const ValueCases values = CasesOf(root, "_deepslam_words \"{}\"; return");
  std::string text = "# bash completion of deepslam, written by `deepslam completion bash`\n";
  text += "_deepslam_words() { mapfile -t COMPREPLY < <(compgen -W \"$1\" -- \"$cur\"); }\n";
  text +=
      "_deepslam_files() { compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen -f "
      "-- \"$cur\"); }\n\n";
  text += "_deepslam() {\n";
  text +=
      "  local cur=\"${COMP_WORDS[COMP_CWORD]}\" prev=\"${COMP_WORDS[COMP_CWORD-1]}\" "
      "before=\"\"\n";
  text += "  local command=\"\" word i setting=\"\"\n";
  text += "  COMPREPLY=()\n";
  text += "  for ((i = 1; i < COMP_CWORD; i++)); do\n";
  text += "    word=\"${COMP_WORDS[i]}\"\n";
  text += "    case \"${command:+$command }$word\" in\n";
  text += fmt::format("      {}) command=\"${{command:+$command }}$word\" ;;\n", KnownPaths(root));
  text += "    esac\n  done\n";
  text += "  if [[ $cur == = ]]; then cur=\"\"; before=\"$prev\"; fi\n";
  text += "  if [[ $prev == = ]]; then before=\"${COMP_WORDS[COMP_CWORD-2]}\"; fi\n";
  text += "  if [[ -n $before ]]; then\n";
  text += "    prev=\"$before\"\n";
  text += "    case \"$before\" in\n";
  for (const auto& [name, words] : settings) {
    if (!words.empty())
      text +=
          fmt::format("      {}) _deepslam_words \"{}\"; return ;;\n", name, Joined(words, " "));
  }
  text += "    esac\n  fi\n";
  text += "  case \"$command $prev\" in\n";
  text += fmt::format(
      "    *' --set') compopt -o nospace 2>/dev/null; _deepslam_words \"{}\"; return ;;\n",
      SettingNames(settings));
  text += values.known;
  text += fmt::format("    {}) _deepslam_files; return ;;\n", values.any);
  text += "  esac\n";
  text += "  case \"$command\" in\n";
  for (const CommandNode* node : AllCommands(root)) {
    const std::vector<std::string> options = OptionNames(*node);
    text += fmt::format("    '{}')\n", PathText(*node));
    text += fmt::format("      if [[ $cur == -* ]]; then _deepslam_words \"{}\"\n",
                        Joined(options, " "));
    if (node->commands.empty()) {
      text += "      else _deepslam_files; fi ;;\n";
    } else {
      text += fmt::format("      else _deepslam_words \"{}\"; fi ;;\n",
                          Joined(CommandNames(*node), " "));
    }
  }
  text += "  esac\n}\ncomplete -F _deepslam deepslam\n";
  return text;
}

std::string ZshCompletion(const CommandNode& root, const SettingWords& settings) {
  const ValueCases values = CasesOf(root, "compadd -- {}; return");
  std::string text =
      "#compdef deepslam\n# zsh completion of deepslam, written by `deepslam completion zsh`\n";
  text += "local command=\"\" word\nlocal -a commands options\n";
  text += "for word in ${words[2,CURRENT-1]}; do\n  case \"${command:+$command }$word\" in\n";
  text += fmt::format("    {}) command=\"${{command:+$command }}$word\" ;;\n", KnownPaths(root));
  text += "  esac\ndone\n";
  text += "case \"$command ${words[CURRENT-1]}\" in\n";
  text += fmt::format("    *' --set') compadd -S '' -- {}; return ;;\n", SettingNames(settings));
  text += values.known;
  text += fmt::format("    {}) _files; return ;;\n", values.any);
  text += "esac\n";
  text += "case \"$command\" in\n";
  const auto entry = [](const std::string& name, const std::string& description) {
    return Quoted(
        fmt::format("{}:{}", Replaced(name, ':', "\\:"), Replaced(description, ':', "\\:")));
  };
  for (const CommandNode* node : AllCommands(root)) {
    text += fmt::format("  '{}')\n    options=(\n", PathText(*node));
    for (const CommandOption& option : node->options) {
      for (const std::string& name : option.names)
        text += fmt::format("      {}\n", entry(name, option.description));
    }
    text += "    )\n    commands=(\n";
    for (const CommandNode& command : node->commands)
      text += fmt::format("      {}\n", entry(command.path.back(), command.description));
    text += "    ) ;;\n";
  }
  text += "esac\n";
  text += "if [[ $PREFIX == -* ]]; then _describe option options\n";
  text += "elif (( $#commands )); then _describe command commands\n";
  text += "else _files; fi\n";
  return text;
}

std::string FishCompletion(const CommandNode& root, const SettingWords& settings) {
  std::string text = "# fish completion of deepslam, written by `deepslam completion fish`\n";
  for (const CommandNode* node : AllCommands(root)) {
    std::string seen;
    for (const std::string& name : node->path)
      seen += fmt::format("{}__fish_seen_subcommand_from {}", seen.empty() ? "" : "; and ", name);
    if (!node->commands.empty()) {
      seen += fmt::format("{}not __fish_seen_subcommand_from {}",
                          seen.empty() ? "" : "; and ",
                          Joined(CommandNames(*node), " "));
    }
    const std::string condition = fmt::format(" -n {}", FishQuoted(seen));
    for (const CommandNode& command : node->commands) {
      text += fmt::format("complete -c deepslam -f{} -a {} -d {}\n",
                          condition,
                          command.path.back(),
                          FishQuoted(command.description));
    }
    for (const CommandOption& option : node->options) {
      text += "complete -c deepslam" + condition;
      for (const std::string& name : option.names)
        text += name.starts_with("--") ? fmt::format(" -l {}", name.substr(2))
                                       : fmt::format(" -s {}", name.substr(1));
      if (option.names.back() == "--set") {
        text += " -x -a " + FishQuoted(SettingNames(settings));
      } else if (!option.choices.empty()) {
        text += " -x -a " + FishQuoted(Joined(option.choices, " "));
      } else if (!option.value.empty()) {
        text += " -r";
      }
      text += " -d " + FishQuoted(option.description) + "\n";
    }
  }
  return text;
}

}  // namespace deepslam::tools
