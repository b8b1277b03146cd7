// Draco payloads by themselves: meshes of our own, of our scenes, and of any program's furniture.
#include "deepslam/gltf/draco_mesh.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(draco) {
  bool accepted = false;
  if (const auto mesh = gltf::DracoDecode(bytes); mesh.ok()) {
    accepted = true;
    for (const auto& face : mesh->faces) {
      for (const auto vertex : face)
        DEEPSLAM_CHECK(static_cast<std::size_t>(vertex) < mesh->vertices.size(),
                       "faces name vertices");
    }
  }
  if (const auto mesh = gltf::DracoDecodeForGltf(bytes, 0, 1, 2); mesh.ok()) accepted = true;
  if (const auto model = gltf::DracoDecodeModel(bytes, {0, 1, 2}); model.ok()) {
    accepted = true;
    for (const auto& face : model->faces) {
      for (const std::uint32_t vertex : face)
        DEEPSLAM_CHECK(vertex < model->positions.size(), "faces name vertices");
    }
  }
  return accepted;
}
