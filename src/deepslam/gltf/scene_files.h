// Several files of one scene, as bytes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/gltf/scene_writer.h"

namespace deepslam::gltf {

struct GlbKind {
  bool draco = true;           // in place of that of the options
  bool objects_alone = false;  // to say how large they are: no surroundings, path or cameras
};

// Each as WriteGlb writes it. Meshes are encoded once for all, side by side.
[[nodiscard]] std::vector<Result<std::string>> WriteGlbs(const GltfScene& scene,
                                                         const GltfOptions& options,
                                                         std::span<const GlbKind> kinds);

}  // namespace deepslam::gltf
