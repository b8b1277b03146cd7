// Furniture models from glTF 2.0 files of any origin: geometry, materials, textures.
#pragma once

#include <cstddef>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/gltf/gltf_buffers.h"
#include "deepslam/scene/textured_mesh.h"

namespace deepslam::gltf {

// `bytes` is a GLB or the JSON of a .gltf; its default scene (else the first, else all nodes) as
// one mesh, node transforms applied, faces of mirrored nodes turned round so that they look out.
// Triangles, strips and fans; plain, quantised (KHR_mesh_quantization) and Draco-compressed
// (KHR_draco_mesh_compression); colour by base colour, texture (with KHR_texture_transform) and
// COLOR_0. Skins and morph targets are left at rest, points and lines left out. Textures that are
// missing are left out; missing or short buffers are errors, as are more faces than `max_faces`,
// which no count in the file is trusted for before its bytes are there. Errors name the field.
[[nodiscard]] Result<TexturedMesh> ReadTexturedModel(std::string_view bytes,
                                                     const ResourceLookup& beside,
                                                     std::size_t max_faces);

}  // namespace deepslam::gltf
