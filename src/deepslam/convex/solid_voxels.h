// Which cells of a grid lie inside a closed mesh.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::convex {

struct SolidVoxels {
  std::vector<Eigen::Vector3f> centres;  // of the cells inside, frame of the mesh
  float cell_m = 0;
};

// `num_cells` along the mesh's longest side. A cell is inside where a line straight up from its
// centre leaves the surface more often than it enters it.
[[nodiscard]] SolidVoxels SolidVoxelsOf(const TriangleMesh& closed, int num_cells);

}  // namespace deepslam::convex
