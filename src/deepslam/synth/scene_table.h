// Tables of a scene file with their faults; of use to scene_description.cc alone.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"

namespace YAML {
class Node;
}

namespace deepslam::synth {

// " (did you mean room?)", or nothing.
[[nodiscard]] std::string NearestOf(const std::string& word, const std::vector<std::string>& known);

// One table of the file. Remembers the first fault and the names that were asked for. Values stay
// as they are where the file does not give them.
class SceneTable {
 public:
  // Without a file, faults name the field alone.
  SceneTable(const YAML::Node& node,
             const std::filesystem::path& file,
             std::string path,
             std::optional<Error>& fault);

  void Number(const std::string& name, double& value, double min, double max);
  void Number(const std::string& name, int& value, int min, int max);
  void Switch(const std::string& name, bool& value);
  void Text(const std::string& name, std::string& value, bool required);
  void Vec(const std::string& name,
           Eigen::Vector2d& value,
           double min,
           double max,
           bool required = false);
  void Vec(const std::string& name,
           Eigen::Vector3d& value,
           double min,
           double max,
           bool required = false);
  void Points(const std::string& name, std::vector<Eigen::Vector3d>& value);
  SceneTable Sub(const std::string& name);
  std::vector<SceneTable> List(const std::string& name);
  // To be called last: what was not asked for is unknown.
  void RefuseOthers();

  // The field's node, for messages.
  YAML::Node At(const std::string& name);
  [[nodiscard]] int line() const;
  void Fail(const YAML::Node& node, const std::string& field, const std::string& what);
  [[nodiscard]] std::string Path(const std::string& name) const;

 private:
  YAML::Node Find(const std::string& name);
  void ReadNumbers(const std::string& name,
                   double* values,
                   std::size_t count,
                   double min,
                   double max,
                   bool required);

  std::shared_ptr<const YAML::Node> node_;
  std::filesystem::path file_;
  std::string path_;
  std::optional<Error>* fault_;
  std::set<std::string> asked_;
};

}  // namespace deepslam::synth
