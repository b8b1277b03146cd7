#include "deepslam/pipeline/config.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "deepslam/artifact/json_value.h"
#include "deepslam/core/nearest_word.h"
#include "deepslam/core/text_numbers.h"
#include "deepslam/pipeline/yaml_values.h"

namespace deepslam::pipeline {
namespace {

using artifact::ShortestDecimal;

// More than anyone mends at a time; aliases make thousands of a small file.
constexpr std::size_t kMaxFaults = 50;
constexpr std::size_t kMaxFaultBytes = 1000;  // a value may be a whole file

std::string Bool(bool value) { return value ? "true" : "false"; }

class Lister final : public OptionsVisitor {
 public:
  explicit Lister(std::string prefix) : prefix_(std::move(prefix)) {}
  void Field(std::string_view name,
             double& value,
             Range range,
             std::string_view unit,
             std::string_view help) override {
    Add(name, OptionKind::kReal, ShortestDecimal(value), help);
    entries.back().range = range;
    entries.back().unit = unit;
  }
  void Field(std::string_view name,
             int& value,
             Range range,
             std::string_view unit,
             std::string_view help) override {
    Add(name, OptionKind::kInteger, std::to_string(value), help);
    entries.back().range = range;
    entries.back().unit = unit;
  }
  void Field(std::string_view name, bool& value, std::string_view help) override {
    Add(name, OptionKind::kFlag, Bool(value), help);
  }
  void Field(std::string_view name, std::string& value, std::string_view help) override {
    Add(name, OptionKind::kText, value, help);
  }
  void Choice(std::string_view name,
              std::string& value,
              std::span<const std::string_view> choices,
              std::string_view help) override {
    Add(name, OptionKind::kChoice, value, help);
    entries.back().choices.assign(choices.begin(), choices.end());
  }
  std::vector<OptionEntry> entries;

 private:
  void Add(std::string_view name, OptionKind kind, std::string value, std::string_view help) {
    entries.push_back({fmt::format("{}.{}", prefix_, name),
                       kind,
                       std::move(value),
                       {},
                       {},
                       std::string(help),
                       {}});
  }
  std::string prefix_;
};

// Sets the fields that `values` names and takes them out of it; collects faults.
class Setter final : public OptionsVisitor {
 public:
  Setter(std::string prefix, AssignedValues& values, std::vector<std::string>& faults)
      : prefix_(std::move(prefix)), values_(values), faults_(faults) {}

  void Field(std::string_view name,
             double& value,
             Range range,
             std::string_view unit,
             std::string_view) override {
    const AssignedValue* given = Take(name);
    if (given == nullptr) return;
    const std::optional<double> number = ParseNumber(given->text);
    if (!number) return Fault(*given, name, fmt::format("must be a number ({})", unit));
    if (*number < range.min || *number > range.max) {
      return Fault(
          *given, name, fmt::format("must lie in [{}, {}] {}", range.min, range.max, unit));
    }
    value = *number;
  }
  void Field(std::string_view name,
             int& value,
             Range range,
             std::string_view unit,
             std::string_view) override {
    const AssignedValue* given = Take(name);
    if (given == nullptr) return;
    const std::optional<int> number = ParseInt(given->text);
    if (!number) return Fault(*given, name, fmt::format("must be an integer ({})", unit));
    if (*number < range.min || *number > range.max) {
      return Fault(
          *given, name, fmt::format("must lie in [{}, {}] {}", range.min, range.max, unit));
    }
    value = *number;
  }
  void Field(std::string_view name, bool& value, std::string_view) override {
    const AssignedValue* given = Take(name);
    if (given == nullptr) return;
    if (given->text != "true" && given->text != "false")
      return Fault(*given, name, "must be true or false");
    value = given->text == "true";
  }
  void Field(std::string_view name, std::string& value, std::string_view) override {
    const AssignedValue* given = Take(name);
    if (given != nullptr) value = given->text;
  }
  void Choice(std::string_view name,
              std::string& value,
              std::span<const std::string_view> choices,
              std::string_view) override {
    const AssignedValue* given = Take(name);
    if (given == nullptr) return;
    if (std::find(choices.begin(), choices.end(), given->text) == choices.end()) {
      return Fault(*given, name, fmt::format("must be one of {}", fmt::join(choices, ", ")));
    }
    value = given->text;
  }
  void Retired(std::string_view name, std::string_view instead) override {
    const AssignedValue* given = Take(name);
    if (given == nullptr) return;
    faults_.push_back(
        fmt::format("{}: {}.{} is no option any more: {}", given->place, prefix_, name, instead));
  }

 private:
  const AssignedValue* Take(std::string_view name) {
    const auto it = values_.find(fmt::format("{}.{}", prefix_, name));
    if (it == values_.end()) return nullptr;
    taken_ = it->second;
    values_.erase(it);
    return &taken_;
  }
  void Fault(const AssignedValue& given, std::string_view name, std::string_view what) {
    faults_.push_back(
        fmt::format("{}: {}.{} is \"{}\", {}", given.place, prefix_, name, given.text, what));
  }

  std::string prefix_;
  AssignedValues& values_;
  std::vector<std::string>& faults_;
  AssignedValue taken_;
};

// Cut before a character of UTF-8, not within.
std::string Shortened(std::string fault) {
  if (fault.size() <= kMaxFaultBytes) return fault;
  std::size_t end = kMaxFaultBytes;
  while (end > 0 && (static_cast<unsigned char>(fault[end]) & 0xC0) == 0x80) --end;
  fault.resize(end);
  return fault + "...";
}

Status Faults(std::vector<std::string> faults) {
  if (faults.empty()) return Ok();
  const bool more = faults.size() > kMaxFaults;
  if (more) faults.resize(kMaxFaults);
  for (std::string& fault : faults) fault = Shortened(std::move(fault));
  if (more) faults.emplace_back("and more; mend these first");
  return InvalidConfig(fmt::format("{}", fmt::join(faults, "\n")));
}

void Apply(std::span<const OptionSection> sections,
           AssignedValues values,
           std::vector<std::string>& faults) {
  std::vector<std::string> known;
  for (const OptionEntry& entry : ListOptions(sections)) known.push_back(entry.name);
  for (const OptionSection& section : sections) {
    Setter setter(section.name, values, faults);
    section.describe(setter);
  }
  for (const auto& [name, value] : values) {
    if (faults.size() > kMaxFaults) return;
    const std::string nearest = NearestWord(name, known);
    faults.push_back(
        fmt::format("{}: unknown option {}{}; `deepslam config dump` lists all",
                    value.place,
                    name,
                    nearest.empty() ? "" : fmt::format(", did you mean {}?", nearest)));
  }
}

std::string CommentOf(const OptionEntry& entry) {
  std::string comment = entry.help;
  if (entry.kind == OptionKind::kReal || entry.kind == OptionKind::kInteger) {
    const bool unitless = entry.unit.empty() || entry.unit == "1";
    comment += fmt::format(" [{} .. {}{}]",
                           ShortestDecimal(entry.range.min),
                           ShortestDecimal(entry.range.max),
                           unitless ? "" : " " + entry.unit);
  } else if (entry.kind == OptionKind::kChoice) {
    comment += fmt::format(" [{}]", fmt::join(entry.choices, " | "));
  }
  std::replace(comment.begin(), comment.end(), '\n', ' ');
  return comment;
}

// Opens the maps of a dotted name that are not open yet.
void OpenMaps(const std::string& name,
              std::vector<std::string>& open,
              std::string_view help,
              std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('.', begin), name.size());
    parts.push_back(name.substr(begin, end - begin));
    begin = end + 1;
  }
  std::size_t shared = 0;
  while (shared < open.size() && shared < parts.size() && open[shared] == parts[shared]) ++shared;
  open.resize(shared);
  for (std::size_t depth = shared; depth < parts.size(); ++depth) {
    const std::string indent(2 * depth, ' ');
    if (depth == 0) text += '\n';
    if (depth + 1 == parts.size() && !help.empty()) text += fmt::format("{}# {}\n", indent, help);
    text += fmt::format("{}{}:\n", indent, parts[depth]);
    open.push_back(parts[depth]);
  }
}

}  // namespace

std::vector<OptionEntry> ListOptions(std::span<const OptionSection> sections) {
  std::vector<OptionEntry> entries;
  for (const OptionSection& section : sections) {
    Lister lister(section.name);
    section.describe(lister);
    entries.insert(entries.end(), lister.entries.begin(), lister.entries.end());
  }
  return entries;
}

std::map<std::string, std::string> OptionValues(const OptionSection& section) {
  std::map<std::string, std::string> values;
  for (const OptionEntry& entry : ListOptions({&section, 1})) values[entry.name] = entry.value;
  return values;
}

Status ApplyYaml(std::span<const OptionSection> sections,
                 std::string_view text,
                 std::string_view name) {
  std::vector<std::string> faults;
  AssignedValues values = ReadYamlValues(text, name, faults);
  Apply(sections, std::move(values), faults);
  return Faults(std::move(faults));
}

Status ApplySettings(std::span<const OptionSection> sections,
                     std::span<const std::string> settings) {
  std::vector<std::string> faults;
  AssignedValues values;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) {
      faults.push_back(
          fmt::format("--set {}: must be NAME=VALUE, like track.max_depth_m=4", setting));
      continue;
    }
    values[setting.substr(0, equals)] = {setting.substr(equals + 1), "--set " + setting};
  }
  Apply(sections, std::move(values), faults);
  return Faults(std::move(faults));
}

Status ApplyValues(std::span<const OptionSection> sections,
                   const std::map<std::string, std::string>& values,
                   std::string_view name) {
  std::vector<std::string> faults;
  AssignedValues assigned;
  for (const auto& [option, value] : values) assigned[option] = {value, std::string(name)};
  Apply(sections, std::move(assigned), faults);
  return Faults(std::move(faults));
}

std::string DumpConfig(std::span<const OptionSection> sections) {
  std::string text =
      "# Every option of deepslam with its default. Files given by --config need to hold "
      "differences only.\n"
      "# In brackets: range and unit, or the choices.\n";
  std::vector<std::string> open;
  for (const OptionSection& section : sections) {
    const std::vector<OptionEntry> entries = ListOptions({&section, 1});
    if (entries.empty()) continue;
    OpenMaps(section.name, open, section.help, text);
    for (const OptionEntry& entry : entries) {
      const std::size_t dot = entry.name.rfind('.');
      OpenMaps(entry.name.substr(0, dot), open, "", text);
      const std::string indent(2 * open.size(), ' ');
      const bool quoted = entry.kind == OptionKind::kText || entry.kind == OptionKind::kChoice;
      text += fmt::format("{}# {}\n{}{}: {}\n",
                          indent,
                          CommentOf(entry),
                          indent,
                          entry.name.substr(dot + 1),
                          quoted ? YamlString(entry.value) : entry.value);
    }
  }
  return text;
}

}  // namespace deepslam::pipeline
