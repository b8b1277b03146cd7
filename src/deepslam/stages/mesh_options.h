// Options of the objects' meshes as the compact map notes them.
#pragma once

#include <map>
#include <string>

#include "deepslam/core/result.h"
#include "deepslam/mesh/object_mesh.h"
#include "deepslam/scene/compact_map.h"
#include "deepslam/stages/config.h"

namespace deepslam::stages {

// Those of mesh.surface and mesh.refine that differ from the defaults, by their full names.
[[nodiscard]] std::map<std::string, std::string> NotedMeshOptions(const Config& config);

// The options that the map's shapes were made by. Errors (kInvalidInput) name the option.
[[nodiscard]] Result<mesh::ObjectMeshOptions> MeshOptionsOf(const CompactMap& map);

}  // namespace deepslam::stages
