// The configuration: every option of every stage in one tree, read from YAML files and `--set`,
// checked at once.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/core/result.h"

namespace deepslam::pipeline {

// A group of options under a dotted name ("track", "detect.clusters"); `describe` describes the one
// struct it stands for.
struct OptionSection {
  std::string name;
  std::string help;  // one line
  std::function<void(OptionsVisitor&)> describe;
};

enum class OptionKind { kReal, kInteger, kFlag, kText, kChoice };

struct OptionEntry {
  std::string name;  // "track.max_depth_m"
  OptionKind kind = OptionKind::kText;
  std::string value;  // canonical text: equal values, equal text
  Range range;        // kReal, kInteger
  std::string unit;
  std::string help;
  std::vector<std::string> choices;  // kChoice
};

// Every option with its present value, in the order of the sections.
[[nodiscard]] std::vector<OptionEntry> ListOptions(std::span<const OptionSection> sections);

// Names and canonical values of one section, names with the section's in front: what goes into a
// stage's key.
[[nodiscard]] std::map<std::string, std::string> OptionValues(const OptionSection& section);

// Sets the options a YAML text names. All faults at once, one per line with `name` and line number:
// no YAML, unknown keys (with the nearest known one), values of the wrong type or out of range.
// Options without fault are set.
[[nodiscard]] Status ApplyYaml(std::span<const OptionSection> sections,
                               std::string_view text,
                               std::string_view name);

// Sets options from texts "track.max_depth_m=4", in order. All faults at once.
[[nodiscard]] Status ApplySettings(std::span<const OptionSection> sections,
                                   std::span<const std::string> settings);

// Sets options from names and canonical values, as OptionValues gives them. Unknown names are
// faults.
[[nodiscard]] Status ApplyValues(std::span<const OptionSection> sections,
                                 const std::map<std::string, std::string>& values,
                                 std::string_view name);

// YAML with meaning, unit and range above every option; reading it back changes nothing.
[[nodiscard]] std::string DumpConfig(std::span<const OptionSection> sections);

}  // namespace deepslam::pipeline
