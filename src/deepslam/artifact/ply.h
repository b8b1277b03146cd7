// Meshes as binary little-endian PLY, opened by Blender, MeshLab, Open3D and others.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/result.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::artifact {

struct PlyMesh {
  TriangleMesh mesh;
  std::vector<Eigen::Vector3f> normals;  // one per vertex, or empty
  std::vector<std::int32_t> labels;      // one per vertex, or empty
};

// Fails on coordinates that are not finite and on faces that name no vertex.
[[nodiscard]] Result<std::string> EncodePly(const PlyMesh& ply, std::string_view name);

// Reads what EncodePly writes: vertices x y z [nx ny nz] [red green blue] [label], triangles.
// Anything else, and every count that the bytes cannot hold, is refused.
[[nodiscard]] Result<PlyMesh> DecodePly(std::string_view bytes, std::string_view name);

}  // namespace deepslam::artifact
