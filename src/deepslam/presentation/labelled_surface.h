// A scene as one mesh whose vertices are labelled.
#pragma once

#include <cstdint>
#include <vector>

#include "deepslam/gltf/scene_writer.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::presentation {

inline constexpr int kGroundLabel = -1;  // negative, as ids of objects are not
inline constexpr int kRoomLabel = -2;    // the measured surface of the room
inline constexpr int kPartLabel = -3;    // a wall, a door, a ceiling

struct LabelledSurface {
  TriangleMesh mesh;                 // world, z up, m; coloured (sRGB)
  std::vector<std::int32_t> labels;  // one per vertex
};

// Every mesh of the scene, one after the other; the label of a vertex is the object's id,
// kGroundLabel for ground, kRoomLabel for the measured room and kPartLabel for its parts.
[[nodiscard]] LabelledSurface JoinSurfaces(const gltf::GltfScene& scene);

}  // namespace deepslam::presentation
