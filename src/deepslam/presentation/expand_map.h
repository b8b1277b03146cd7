// The scene again from the compact map alone.
#pragma once

#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/mesh/object_mesh.h"
#include "deepslam/scene/compact_map.h"
#include "deepslam/scene/model_library.h"

namespace deepslam::presentation {

// Whether any object of the map needs the library.
[[nodiscard]] bool NeedsLibrary(const CompactMap& map);

// Objects with ids, names, classes, poses, shapes and class colours, the room itself in plain
// colours, and the ground. `library` may be null when no object needs it; `options` are those that
// the map's shapes were made by. Errors (kInvalidInput), each naming the object: its model is not
// in the library or is another there; its shape is a network's and no decoder is installed; its
// voxels are damaged; its outline of the ground crosses itself.
[[nodiscard]] Result<gltf::GltfScene> ExpandMap(const CompactMap& map,
                                                const ModelLibrary* library,
                                                const mesh::ObjectMeshOptions& options,
                                                std::string_view tool_version);

}  // namespace deepslam::presentation
