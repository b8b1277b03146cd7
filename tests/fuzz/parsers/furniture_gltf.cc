// Furniture in glTF and GLB; every file that a glTF names holds the same few bytes.
#include <string>

#include "deepslam/gltf/textured_model.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(furniture_gltf) {
  constexpr std::size_t kMaxFaces = 10'000;
  const auto beside = [](const std::string& path) -> std::optional<std::string> {
    DEEPSLAM_CHECK(StaysBelow(path), "what a glTF names lies beside it");
    return std::string(256, '\x3e');
  };
  const auto model = gltf::ReadTexturedModel(bytes, beside, kMaxFaces);
  if (!model.ok()) return false;
  DEEPSLAM_CHECK(model->faces.size() <= kMaxFaces, "faces are bounded");
  for (const TexturedMesh::Face& face : model->faces) {
    for (const std::uint32_t vertex : face.vertices)
      DEEPSLAM_CHECK(vertex < model->vertices.size(), "faces name vertices");
    DEEPSLAM_CHECK(face.material < static_cast<int>(model->materials.size()), "and materials");
  }
  return !model->faces.empty();
}
