#include "deepslam/stages/mesh_options.h"

#include <set>

#include <fmt/format.h>

#include "deepslam/pipeline/config.h"

namespace deepslam::stages {

std::map<std::string, std::string> NotedMeshOptions(const Config& config) {
  const std::set<std::string> sections = {"mesh.surface", "mesh.refine"};
  const std::map<std::string, std::string> defaults = KeyOptions(Config(), sections);
  std::map<std::string, std::string> options = KeyOptions(config, sections);
  std::erase_if(options,
                [&](const auto& option) { return defaults.at(option.first) == option.second; });
  return options;
}

Result<mesh::ObjectMeshOptions> MeshOptionsOf(const CompactMap& map) {
  Config config;
  for (const auto& [option, value] : map.mesh_options) {
    if (!option.starts_with("mesh.")) {
      return InvalidInput(fmt::format("map.json: mesh_options.{} is no option of mesh", option));
    }
  }
  const Status status =
      pipeline::ApplyValues(Sections(config), map.mesh_options, "map.json: mesh_options");
  if (!status.ok()) return InvalidInput(status.error().message);
  return mesh::ObjectMeshOptions{config.surface, config.refine};
}

}  // namespace deepslam::stages
