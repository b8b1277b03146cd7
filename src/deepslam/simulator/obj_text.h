// A mesh as Wavefront OBJ.
#pragma once

#include <string>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::simulator {

// Vertices to 0.01 mm, with their colours behind them where the mesh has any (MeshLab, Blender and
// trimesh read these; others pass over them).
[[nodiscard]] std::string ObjText(const TriangleMesh& mesh);

}  // namespace deepslam::simulator
