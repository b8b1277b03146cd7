// The pair of files that Habitat reads a scene with its labels from.
#pragma once

#include <string>

#include "deepslam/core/result.h"
#include "deepslam/gltf/scene_writer.h"

namespace deepslam::presentation {

struct HabitatPair {
  std::string glb;  // scene.semantic.glb: objects, ground and room in flat vertex colours, no Draco
  std::string
      txt;  // scene.semantic.txt: `HM3D Semantic Annotations`, then id,HEXRGB,"category",region
};
// Every object has a colour of its own; ground is "floor", room is "unknown"; all in region 0. The
// hexadecimal colours are sRGB, the file's vertex colours their linear equivalents, as glTF wants.
[[nodiscard]] Result<HabitatPair> EncodeHabitatPair(const gltf::GltfScene& scene);

}  // namespace deepslam::presentation
