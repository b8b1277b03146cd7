// Draco payloads by themselves: of our scenes, and of any program's furniture.
#include "deepslam/gltf/draco_decode.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(draco) {
  bool accepted = false;
  for (const bool strict : {true, false}) {
    for (const int normal : {-1, 1}) {
      const auto mesh = gltf::DracoDecode(
          bytes, {.position = 0, .normal = normal, .place = 2, .colour = 1, .strict = strict});
      if (!mesh.ok()) continue;
      accepted = true;
      for (const auto& face : mesh->faces) {
        for (const std::uint32_t vertex : face)
          DEEPSLAM_CHECK(vertex < mesh->positions.size(), "faces name vertices");
      }
      for (const std::size_t count :
           {mesh->normals.size(), mesh->places.size(), mesh->colours.size()})
        DEEPSLAM_CHECK(count == 0 || count == mesh->positions.size(), "one for every vertex");
    }
  }
  return accepted;
}
