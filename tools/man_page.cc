#include "man_page.h"

#include <fmt/format.h>

namespace deepslam::tools {
namespace {

// Text as roff shows it unchanged: no control lines, no hyphens for minus signs.
std::string Escaped(std::string_view text) {
  std::string out;
  if (text.starts_with('.')) out = "\\&";
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '`') {
      out += "\\(aq";  // the sources quote commands `so`
    } else if (c == '\'') {
      out += "\\(aq";
    } else if (c == '"') {
      out += "\\(dq";
    } else {
      out += c;
    }
  }
  return out;
}

std::string Synopsis(const CommandNode& node) {
  std::string line = "\\fBdeepslam";
  if (!node.path.empty()) line += fmt::format(" {}", Escaped(PathText(node)));
  line += "\\fR";
  for (const CommandOption& option : node.options) {
    if (!option.required) continue;
    line +=
        fmt::format(" \\fB{}\\fR \\fI{}\\fR", Escaped(option.names.front()), Escaped(option.value));
  }
  line += " [\\fIOPTIONS\\fR]";
  for (const CommandOption& positional : node.positionals) {
    const std::string name = fmt::format("\\fI{}\\fR", Escaped(positional.names.front()));
    line += fmt::format(fmt::runtime(positional.required ? " {}{}" : " [{}{}]"),
                        name,
                        positional.repeatable ? " ..." : "");
  }
  if (!node.commands.empty()) line += " \\fICOMMAND\\fR";
  return line;
}

std::string Entry(const CommandOption& option) {
  std::string text = ".TP\n";
  if (option.names.front().starts_with("-")) {
    std::string names;
    for (const std::string& name : option.names)
      names += fmt::format("{}\\fB{}\\fR", names.empty() ? "" : ", ", Escaped(name));
    if (!option.value.empty()) names += fmt::format(" \\fI{}\\fR", Escaped(option.value));
    text += names + "\n";
  } else {
    text += fmt::format("\\fI{}\\fR\n", Escaped(option.names.front()));
  }
  text += Escaped(option.description);
  std::string more;
  const auto add = [&more](const std::string& word) {
    if (!more.empty()) more += "; ";
    more += word;
  };
  if (option.required && option.names.front().starts_with("-")) add("required");
  if (!option.choices.empty()) {
    std::string choices;
    for (const std::string& choice : option.choices)
      choices += fmt::format("{}{}", choices.empty() ? "" : " | ", choice);
    add(choices);
  }
  if (!option.range.empty()) add(option.range);
  if (!option.default_text.empty()) add(fmt::format("default {}", option.default_text));
  if (!more.empty()) text += fmt::format(" [{}]", Escaped(more));
  return text + "\n";
}

std::string Section(const CommandNode& node) {
  std::string text = fmt::format(".SS deepslam {}\n{}.\n.PP\n{}\n",
                                 Escaped(PathText(node)),
                                 Escaped(node.description),
                                 Synopsis(node));
  for (const CommandOption& positional : node.positionals) text += Entry(positional);
  for (const CommandOption& option : node.options) {
    // The same everywhere: said once, with the program's own.
    if (option.names.back() == "--help" || option.names.back() == "--help-all") continue;
    text += Entry(option);
  }
  return text;
}

constexpr std::string_view kClosing = R"(.SH EXIT STATUS
.TP
0
done
.TP
1
failed while running; of a batch: some captures failed
.TP
2
wrong usage or configuration
.TP
3
input unusable
.TP
130
interrupted; the same command goes on
.SH ENVIRONMENT
.TP
.B DEEPSLAM_DATA
Folder of weights and furniture library. Without it PREFIX/share/deepslam, where that holds them, else
.IR ${XDG_DATA_HOME:\-~/.local/share}/deepslam .
.SH FILES
.TP
.I WORKSPACE/export/scene.glb
the scene; any glTF viewer opens it
.TP
.I WORKSPACE/report/index.html
what was found and how good it is
.TP
.I WORKSPACE/overrides.yaml
corrections by hand
.SH SEE ALSO
.BR deepslam\-fetch\-weights (1)
and
.BR deepslam\-demo (1)
with \fB\-\-help\fR; options of the stages: \fBdeepslam config dump\fR; documents: PREFIX/share/doc/deepslam
)";

}  // namespace

std::string ManPage(const CommandNode& root, std::string_view version) {
  std::string text = fmt::format(
      ".TH DEEPSLAM 1 \"\" \"deepslam {}\" \"User Commands\"\n"
      ".SH NAME\ndeepslam \\- {}\n"
      ".SH SYNOPSIS\n{}\n"
      ".SH DESCRIPTION\n"
      "Takes a recorded RGB\\-D sequence to a compact scene in which every piece of furniture is a "
      "closed, metric, labelled mesh. It writes every intermediate result to disk and goes on "
      "where it was stopped.\n"
      ".SH OPTIONS\n",
      version,
      Escaped(root.description),
      Synopsis(root));
  for (const CommandOption& option : root.options) text += Entry(option);
  text += ".SH COMMANDS\n";
  for (const CommandNode* node : AllCommands(root)) {
    if (!node->path.empty()) text += Section(*node);
  }
  return text + std::string(kClosing);
}

}  // namespace deepslam::tools
