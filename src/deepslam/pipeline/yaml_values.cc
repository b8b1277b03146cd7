#include "deepslam/pipeline/yaml_values.h"

#include <algorithm>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "deepslam/core/yaml_quotes.h"

namespace deepslam::pipeline {
namespace {

// Aliases can make a small file huge: what no honest configuration reaches is refused.
constexpr std::size_t kMaxBytes = 1U << 20;
constexpr std::size_t kMaxValues = 10'000;  // entries: far more than there are options
constexpr int kMaxNesting = 8;              // maps in maps; options nest far less deep

class Flattener {
 public:
  Flattener(std::string_view name, std::vector<std::string>& faults)
      : name_(name), faults_(faults) {}

  void Flatten(const YAML::Node& node, const std::string& prefix, int depth) {
    for (const auto& item : node) {
      // Whatever an entry is: aliases repeat faulty ones as well.
      if (++num_entries_ > kMaxValues || depth > kMaxNesting) {
        if (!overflow_) Fault(node, "holds more or deeper entries than any configuration");
        overflow_ = true;
      }
      if (overflow_) return;
      if (!item.first.IsScalar()) {
        Fault(item.first, "a key must be a word");
        continue;
      }
      const std::string key =
          prefix.empty() ? item.first.Scalar() : prefix + "." + item.first.Scalar();
      if (item.second.IsMap()) {
        Flatten(item.second, key, depth + 1);
      } else if (item.second.IsScalar()) {
        const bool fresh =
            values.emplace(key, AssignedValue{item.second.Scalar(), Place(item.second)}).second;
        if (!fresh) Fault(item.first, fmt::format("{} stands twice", key));
      } else if (!item.second.IsNull()) {
        Fault(item.first, fmt::format("{} must be a single value or a map, not a list", key));
      }
    }
  }

  void Fault(const YAML::Node& node, std::string_view what) {
    faults_.push_back(fmt::format("{}: {}", Place(node), what));
  }

  AssignedValues values;

 private:
  std::string Place(const YAML::Node& node) const {
    return fmt::format("{}:{}", name_, node.Mark().line + 1);
  }

  std::string name_;
  std::vector<std::string>& faults_;
  std::size_t num_entries_ = 0;
  bool overflow_ = false;
};

}  // namespace

AssignedValues ReadYamlValues(std::string_view text,
                              std::string_view name,
                              std::vector<std::string>& faults) {
  if (text.size() > kMaxBytes) {
    faults.push_back(
        fmt::format("{}: {} bytes are too many for a configuration", name, text.size()));
    return {};
  }
  try {
    Flattener flattener(name, faults);
    const YAML::Node root = YAML::Load(std::string(text));
    if (root.IsMap()) {
      flattener.Flatten(root, "", 0);
    } else if (!root.IsNull()) {
      flattener.Fault(root, "must be a map of options");
    }
    return std::move(flattener.values);
  } catch (const YAML::Exception& e) {
    faults.push_back(fmt::format("{}:{}: {}", name, e.mark.line + 1, e.msg));
    return {};
  }
}

std::string YamlString(const std::string& text) {
  const bool plain = !IsNullYaml(text) && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '/' || c == '.';
  });
  if (plain && text.front() != '-' && text.front() != '.') return text;
  return DoubleQuotedYaml(text);
}

}  // namespace deepslam::pipeline
