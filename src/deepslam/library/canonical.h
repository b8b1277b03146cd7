// A catalogue's mesh becomes a canonical model: z up, x front, real size.
#pragma once

#include <string>
#include <string_view>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "deepslam/library/catalogue.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::library {

struct CanonicalModel {
  VoxelGrid shape;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // along object x (front), y (left), z (up)
  int quarter_turns = 0;  // counter-clockwise about z, that brought the front there (TurnGrid)
};

// Faces of an OBJ file, in its own coordinates. Materials are not looked at; faces that
// tinyobjloader cannot use are left out. Error: not readable as OBJ, or no face.
[[nodiscard]] Result<TriangleMesh> ReadObj(const std::string& obj_bytes);

// Turns the mesh by the item's rotation, scales it to the catalogue's size, and voxelises it in the
// object frame. The front is the catalogue's (+z of the file) unless the shape contradicts: the
// back of a seat and the head of a bed rise behind.
[[nodiscard]] Result<CanonicalModel> MakeCanonical(const TriangleMesh& mesh_file,
                                                   const CatalogueItem& item,
                                                   std::string_view class_name);

}  // namespace deepslam::library
