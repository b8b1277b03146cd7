// YAML maps flattened to dotted names, so that options can be set from files and from the command
// line alike.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace deepslam::pipeline {

struct AssignedValue {
  std::string text;
  std::string place;  // "paper.yaml:12" or "--set a.b=v"
};
using AssignedValues = std::map<std::string, AssignedValue>;

// Maps of maps of scalars; lists, keys given twice, and what is no YAML at all become faults with
// file and line.
[[nodiscard]] AssignedValues ReadYamlValues(std::string_view text,
                                            std::string_view name,
                                            std::vector<std::string>& faults);

// A text as a YAML scalar that reads back as the same text.
[[nodiscard]] std::string YamlString(const std::string& text);

}  // namespace deepslam::pipeline
