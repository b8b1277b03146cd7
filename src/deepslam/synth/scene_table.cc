#include "deepslam/synth/scene_table.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "deepslam/core/nearest_word.h"

namespace deepslam::synth {
namespace {

constexpr std::size_t kMaxListedPoints = 1000;  // longer lists are refused

std::string Shown(const YAML::Node& node) {
  return node.IsScalar() ? node.Scalar().substr(0, 60) : "a structure";
}

}  // namespace

std::string NearestOf(const std::string& word, const std::vector<std::string>& known) {
  const std::string nearest = NearestWord(word, known);
  return nearest.empty() ? nearest : fmt::format(" (did you mean {}?)", nearest);
}

SceneTable::SceneTable(const YAML::Node& node,
                       const std::filesystem::path& file,
                       std::string path,
                       std::optional<Error>& fault)
    : node_(std::make_shared<const YAML::Node>(node)),
      file_(file),
      path_(std::move(path)),
      fault_(&fault) {
  if (node_->IsDefined() && !node_->IsNull() && !node_->IsMap())
    Fail(*node_, path_, "is not a table");
}

void SceneTable::Number(const std::string& name, double& value, double min, double max) {
  const YAML::Node node = Find(name);
  if (!node) return;
  double read = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, read) ||
      !(read >= min && read <= max)) {
    Fail(node,
         Path(name),
         fmt::format("is '{}', expected a number of {} .. {}", Shown(node), min, max));
    return;
  }
  value = read;
}

void SceneTable::Number(const std::string& name, int& value, int min, int max) {
  double read = value;
  Number(name, read, min, max);
  if (read != std::floor(read)) {
    Fail(Find(name), Path(name), fmt::format("is '{}', expected a whole number", read));
    return;
  }
  value = static_cast<int>(read);
}

void SceneTable::Switch(const std::string& name, bool& value) {
  const YAML::Node node = Find(name);
  if (!node) return;
  if (!node.IsScalar() || !YAML::convert<bool>::decode(node, value)) {
    Fail(node, Path(name), fmt::format("is '{}', expected true or false", Shown(node)));
  }
}

void SceneTable::Text(const std::string& name, std::string& value, bool required) {
  const YAML::Node node = Find(name);
  if (!node) {
    if (required) Fail(*node_, Path(name), "is missing");
    return;
  }
  if (!node.IsScalar() || node.Scalar().empty()) {
    Fail(node, Path(name), "is not a word");
    return;
  }
  value = node.Scalar();
}

void SceneTable::Points(const std::string& name, std::vector<Eigen::Vector3d>& value) {
  const YAML::Node node = Find(name);
  if (!node) return;
  if (!node.IsSequence() || node.size() > kMaxListedPoints) {
    Fail(node, Path(name), fmt::format("is not a list of at most {} points", kMaxListedPoints));
    return;
  }
  value.clear();
  for (std::size_t i = 0; i < node.size(); ++i) {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      double& x = point[static_cast<Eigen::Index>(k)];
      if (node[i].IsSequence() && node[i].size() == 3 && node[i][k].IsScalar() &&
          YAML::convert<double>::decode(node[i][k], x) && std::abs(x) <= 100)
        continue;
      Fail(node[i],
           fmt::format("{}[{}]", Path(name), i),
           "is not a point: a list of 3 numbers of -100 .. 100");
      return;
    }
    value.push_back(point);
  }
}

std::vector<SceneTable> SceneTable::List(const std::string& name) {
  const YAML::Node node = Find(name);
  std::vector<SceneTable> tables;
  if (!node) return tables;
  if (!node.IsSequence()) {
    Fail(node, Path(name), "is not a list");
    return tables;
  }
  for (std::size_t i = 0; i < node.size(); ++i) {
    tables.emplace_back(node[i], file_, fmt::format("{}[{}]", Path(name), i), *fault_);
  }
  return tables;
}

void SceneTable::RefuseOthers() {
  if (!node_->IsMap()) return;
  for (const auto& entry : *node_) {
    const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (asked_.contains(name)) continue;
    const std::vector<std::string> known(asked_.begin(), asked_.end());
    Fail(entry.first,
         Path(name),
         fmt::format(
             "is unknown{}; known here: {}", NearestOf(name, known), fmt::join(known, ", ")));
  }
}

YAML::Node SceneTable::At(const std::string& name) { return Find(name); }

int SceneTable::line() const { return node_->Mark().is_null() ? 0 : node_->Mark().line + 1; }

void SceneTable::Fail(const YAML::Node& node, const std::string& field, const std::string& what) {
  if (*fault_) return;
  if (file_.empty()) {
    *fault_ = InvalidConfig(fmt::format("field '{}' {}", field, what));
    return;
  }
  const bool has_line = node.IsDefined() && !node.Mark().is_null();
  const std::string place =
      has_line ? fmt::format("{}:{}", file_.string(), node.Mark().line + 1) : file_.string();
  *fault_ = InvalidConfig(fmt::format("{}: field '{}' {}", place, field, what));
}

std::string SceneTable::Path(const std::string& name) const {
  return path_.empty() ? name : path_ + "." + name;
}

YAML::Node SceneTable::Find(const std::string& name) {
  asked_.insert(name);
  if (!node_->IsMap()) return YAML::Node(YAML::NodeType::Undefined);
  // A lookup that fails gives a node that throws at every question.
  const YAML::Node found = (*node_)[name];
  return found.IsDefined() ? found : YAML::Node(YAML::NodeType::Undefined);
}

SceneTable SceneTable::Sub(const std::string& name) {
  return SceneTable(Find(name), file_, Path(name), *fault_);
}

void SceneTable::Vec(
    const std::string& name, Eigen::Vector2d& value, double min, double max, bool required) {
  ReadNumbers(name, value.data(), 2, min, max, required);
}

void SceneTable::Vec(
    const std::string& name, Eigen::Vector3d& value, double min, double max, bool required) {
  ReadNumbers(name, value.data(), 3, min, max, required);
}

void SceneTable::ReadNumbers(const std::string& name,
                             double* values,
                             std::size_t count,
                             double min,
                             double max,
                             bool required) {
  const YAML::Node node = Find(name);
  if (!node) {
    if (required) Fail(*node_, Path(name), "is missing");
    return;
  }
  if (!node.IsSequence() || node.size() != count) {
    Fail(node, Path(name), fmt::format("is not a list of {} numbers", count));
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    double read = 0;
    if (!node[i].IsScalar() || !YAML::convert<double>::decode(node[i], read) ||
        !(read >= min && read <= max)) {
      Fail(node[i],
           fmt::format("{}[{}]", Path(name), i),
           fmt::format("is '{}', expected a number of {} .. {}", Shown(node[i]), min, max));
      return;
    }
    values[i] = read;
  }
}

}  // namespace deepslam::synth
