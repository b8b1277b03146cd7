// Furniture models for rendered scenes, at real size in the object frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "deepslam/scene/textured_mesh.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::synth {

// One furniture model: z up, x front, origin at the middle of its box, metres. Every face has
// corners of its own, coloured by its material (diffuse colour, times the texture at the corner
// where there is one).
struct FurnitureModel {
  TriangleMesh mesh;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // along x (front), y, z
  std::vector<std::uint8_t> shiny;    // per face: 1 where depth cameras see nothing (glass, chrome)
  std::vector<std::string> warnings;  // textures that are left out, and why
};

// More would cost gigabytes of memory: some 500 bytes a face, in each place where the model stands.
inline constexpr std::size_t kMaxModelFaces = 2'000'000;
// What to say of more.
[[nodiscard]] Error TooManyFaces(std::size_t num_faces);

// Catalogue sizes, metres: width along the file's x, depth along z (the front is +z), height along
// y (up).
struct CatalogueSize {
  double width_m = 0;
  double depth_m = 0;
  double height_m = 0;
};

// The mesh is turned by `rotation` (the catalogue's modelRotation), then its box scaled to `size`.
// Textures are PNG, JPEG and WebP; what cannot be decoded is left out with a warning. Large
// textured faces are divided, so that corners carry the texture's detail. Without a size the file's
// own is kept, in metres. It need not be closed, oriented or manifold. Errors: no faces, too many,
// a vertex that is not there or not finite, a flat model, sizes that are not positive.
Result<FurnitureModel> MakeFurnitureModel(const TexturedMesh& mesh,
                                          const Eigen::Matrix3d& rotation,
                                          const std::optional<CatalogueSize>& size);

}  // namespace deepslam::synth
