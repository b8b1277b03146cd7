// What is wrong with a glTF, with its place ("accessors[3].count: ...").
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace deepslam::gltf {

inline constexpr std::size_t kMaxFindings = 100;  // a broken file may have one at every vertex

// The first kMaxFindings of each kind are kept.
struct Findings {
  std::vector<std::string> errors;  // what cannot be read
  std::vector<std::string> warnings;
  std::size_t num_errors = 0;  // kept or not
  // Whether what the standard forbids and a reader can do without is an error: of scenes of the
  // program's own, not of furniture from anywhere.
  bool strict = false;

  [[nodiscard]] bool ok() const { return num_errors == 0; }
  void Error(const std::string& place, const std::string& what);
  void Breach(const std::string& place, const std::string& what);  // of the standard alone
  void Warn(const std::string& place, const std::string& what);
};

}  // namespace deepslam::gltf
