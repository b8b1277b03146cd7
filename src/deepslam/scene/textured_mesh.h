// A mesh with its materials, as furniture comes in files: what the readers of OBJ and glTF give and
// what places models in rendered rooms takes.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace deepslam {

struct SurfaceMaterial {
  // Display values (sRGB) in [0, 1]: of the surface where it has no texture, and what a texture is
  // multiplied by.
  Eigen::Vector3f diffuse{0.6f, 0.6f, 0.6f};
  Eigen::Vector3f tint{1, 1, 1};
  int texture = -1;    // of the mesh's textures; -1: none
  bool shiny = false;  // glass or polished metal: depth cameras see nothing there
};

// Frame of the file: x left, y up, z to the front (that of glTF, and of furniture in OBJ); its own
// unit. Faces name vertices; corners have places in the texture of their own.
struct TexturedMesh {
  struct Face {
    std::array<std::uint32_t, 3> vertices{};
    // In the texture: v = 0 is its lower edge; repeated beyond [0, 1].
    std::array<Eigen::Vector2f, 3> places = {
        Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero()};
    int material = -1;  // -1: grey
  };
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3f> colours;  // display values per vertex, times the material; or empty
  std::vector<Face> faces;
  std::vector<SurfaceMaterial> materials;
  std::vector<std::string> textures;  // bytes of the image files (JPEG, PNG, ...), unchecked
};

}  // namespace deepslam
