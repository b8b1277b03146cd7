// Scene files made on request: the labelled PLY and the pair that Habitat reads.
#pragma once

#include <string>

#include "deepslam/core/result.h"
#include "deepslam/gltf/scene_writer.h"

namespace deepslam::stages {

// scene.ply: every mesh of the scene in the world frame (z up, metres), one after the other;
// `label` of a vertex is the object's id, kGroundLabel for ground and kRoomLabel for the room.
inline constexpr int kGroundLabel = -1;
inline constexpr int kRoomLabel = -2;
[[nodiscard]] Result<std::string> EncodeLabelledPly(const gltf::GltfScene& scene);

struct HabitatPair {
  std::string glb;  // scene.semantic.glb: objects, ground and room in flat vertex colours, no Draco
  std::string
      txt;  // scene.semantic.txt: `HM3D Semantic Annotations`, then id,HEXRGB,"category",region
};
// Every object has a colour of its own; ground is "floor", room is "unknown"; all in region 0. The
// hexadecimal colours are sRGB, the file's vertex colours their linear equivalents, as glTF wants.
[[nodiscard]] Result<HabitatPair> EncodeHabitatPair(const gltf::GltfScene& scene);

}  // namespace deepslam::stages
