// Materials of a glTF: colour, texture and how it is laid on.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/gltf/gltf_buffers.h"
#include "deepslam/gltf/json_place.h"
#include "deepslam/scene/textured_mesh.h"

namespace deepslam::gltf {

// Which of the mesh's coordinates a texture takes, and KHR_texture_transform.
struct TexturePlacement {
  int set = 0;  // TEXCOORD_<set>
  Eigen::Vector2f offset = Eigen::Vector2f::Zero();
  Eigen::Vector2f scale = Eigen::Vector2f::Ones();
  float rotation_rad = 0;

  // From glTF's place, whose v runs downwards, to one whose v runs upwards.
  [[nodiscard]] Eigen::Vector2f operator()(const Eigen::Vector2f& uv) const;
};

struct GltfMaterials {
  std::vector<SurfaceMaterial> surfaces;     // as many as the file has
  std::vector<TexturePlacement> placements;  // of each of them
  std::vector<std::string> textures;         // image files that surfaces name
};

// As far as the first error. Textures that are missing are left out.
[[nodiscard]] GltfMaterials ReadMaterials(const JsonPlace& root, GltfBuffers& buffers);

// What a display shows, from linear light: sRGB.
[[nodiscard]] Eigen::Vector3f DisplayFromLinear(const Eigen::Vector3f& linear);

}  // namespace deepslam::gltf
