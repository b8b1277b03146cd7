// Furniture models for rendered scenes: Wavefront OBJ with its materials, brought to real size in
// the object frame.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::synth {

// One furniture model: z up, x front, origin at the middle of its box, metres. Every face has
// corners of its own, coloured by its material (diffuse colour, times the texture at the corner
// where there is one).
struct FurnitureModel {
  TriangleMesh mesh;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // along x (front), y, z
  std::vector<std::uint8_t> shiny;  // per face: 1 where depth cameras see nothing (glass, chrome)
};

// Bytes of a file that lies beside the OBJ (material library, texture), by the name the OBJ or MTL
// uses; nothing when there is none.
using FileLookup = std::function<std::optional<std::string>(const std::string& name)>;

// Catalogue sizes, metres: width along the OBJ's x, depth along z (the front is +z), height along y
// (up).
struct CatalogueSize {
  double width_m = 0;
  double depth_m = 0;
  double height_m = 0;
};

// The OBJ is turned by `rotation` (the catalogue's modelRotation), then its box scaled to `size`.
// What is missing or broken of materials becomes grey. Large textured faces are divided, so that
// corners carry the texture's detail. Without a size the file's own is kept, in metres. Errors: no
// faces, a flat model, sizes that are not positive.
Result<FurnitureModel> ParseObjModel(const std::string& obj_bytes,
                                     const FileLookup& beside,
                                     const Eigen::Matrix3d& rotation,
                                     const std::optional<CatalogueSize>& size);

}  // namespace deepslam::synth
