// Furniture in Wavefront OBJ with its materials.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "deepslam/core/result.h"
#include "deepslam/scene/textured_mesh.h"
#include "deepslam/synth/furniture_model.h"

namespace deepslam::synth {

// Bytes of a file that lies beside the OBJ (material library, texture), by the name the OBJ or MTL
// uses, never one that leads away from the OBJ's folder; nothing when there is none.
using FileLookup = std::function<std::optional<std::string>(const std::string& name)>;

// What is missing of materials becomes grey. Errors: what is no OBJ, too many faces. Faces may name
// vertices that are not there.
Result<TexturedMesh> ReadObj(const std::string& obj_bytes, const FileLookup& beside);

// The two steps in one: ReadObj, MakeFurnitureModel.
Result<FurnitureModel> ParseObjModel(const std::string& obj_bytes,
                                     const FileLookup& beside,
                                     const Eigen::Matrix3d& rotation,
                                     const std::optional<CatalogueSize>& size);

}  // namespace deepslam::synth
